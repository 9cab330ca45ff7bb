"""The report as a JSON document: every figure beside its target, and every single outcome."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.study import Extent
from truepose import __version__
from truepose.reports.table_report import Section


def report_document(
    extent: Extent, sections: Sequence[Section], outcomes: Mapping[str, Sequence[Outcome]]
) -> dict[str, Any]:
    """Return the document; `outcomes` stand by the key of their study."""
    return {
        "program_version": __version__,
        "extent": asdict(extent),
        "sections": [section_document(section) for section in sections],
        "outcomes": {key: [finite(asdict(one)) for one in rows] for key, rows in outcomes.items()},
    }


def finite(value: Any) -> Any:
    """Return the value with null for every number that JSON has no word for."""
    match value:
        case float():
            return value if math.isfinite(value) else None
        case dict():
            return {key: finite(part) for key, part in value.items()}
        case list() | tuple():
            return [finite(part) for part in value]
    return value


def section_document(section: Section) -> dict[str, Any]:
    """Return a section with its rows."""
    rows = [
        {
            "figure": row.figure,
            "target": row.target,
            "measured": row.measured,
            "verdict": row.verdict.value,
        }
        for row in section.rows
    ]
    return {"title": section.title, "note": section.note, "rows": rows}
