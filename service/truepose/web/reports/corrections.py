"""Reports of corrected files."""

from typing import TYPE_CHECKING, Any

from truepose.storage.records import CorrectionRecord
from truepose.web.context import Context
from truepose.web.reports.kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.results.kinds import Choice
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.traceability.conditions import ReportConditions


def draw_correction(report: Any) -> str:
    """Return the report as a page."""
    from truepose.reports.correcting.report import correction_page

    return correction_page(report)


async def _rows(here: Context, month: str) -> list[ReportRow]:
    return [
        ReportRow(
            "correction",
            one.id,
            "reports.correction",
            one.recorded_at,
            one.robot,
            one.name,
            one.simulated,
        )
        for one in await here.corrections.newest_of(LISTED, month)
    ]


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    from truepose.reports.correcting.report import CorrectionInput

    record, targets = await here.corrections.get(number), await here.corrections.targets(number)
    hashes = (record.original_sha256, record.corrected_sha256)

    async def conditions(_: Catalogue) -> "ReportConditions":
        return _conditions(record)

    return Drawable(
        (number, *hashes),
        conditions,
        draw_correction,
        lambda whole: CorrectionInput(
            record.name, record.robot, record.correction, targets, hashes, whole, words.tag
        ),
    )


def _conditions(record: CorrectionRecord) -> "ReportConditions":
    from truepose.reports.traceability.conditions import ReportConditions

    return ReportConditions(simulated=record.simulated)


CORRECTION = ReportKind("correction", "reports.correction", _rows, _drawable)
