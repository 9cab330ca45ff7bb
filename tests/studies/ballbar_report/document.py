"""The report as a JSON document: every figure beside its target, and every robot by itself."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from tests.studies.ballbar_report.connections import SlipCounts
from tests.studies.ballbar_report.robots import Outcome
from tests.studies.ballbar_report.work import Extent
from tests.studies.diagnosis_report.document import finite, section_document
from truepose import __version__
from truepose.reports.table_report import Section


def ballbar_document(
    extent: Extent, sections: Sequence[Section], outcomes: Sequence[Outcome], slips: SlipCounts | None
) -> dict[str, Any]:
    """Return the document; `slips` is None where none were made."""
    return {
        "program_version": __version__,
        "extent": asdict(extent),
        "sections": [section_document(section) for section in sections],
        "robots": [finite(asdict(outcome)) for outcome in outcomes],
        "connections": None if slips is None else asdict(slips),
    }
