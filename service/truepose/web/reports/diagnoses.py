"""Reports of diagnoses."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from truepose.exchange.results.diagnosis import diagnosis_document
from truepose.storage.records import DiagnosisRecord
from truepose.web.context import Context
from truepose.web.records.diagnosis_pages import measured_words
from truepose.web.reports.conditions import conditions_of_campaign
from truepose.web.reports.kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.results.kinds import Choice
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.reports.traceability.conditions import ReportConditions


def draw_diagnosis(report: Any) -> str:
    """Return the report as a page."""
    from truepose.reports.diagnosis_report import diagnosis_page

    return diagnosis_page(report)


async def _rows(here: Context, month: str) -> list[ReportRow]:
    return [
        ReportRow(
            "diagnosis",
            one.id,
            "reports.diagnosis",
            one.recorded_at,
            one.diagnosis.robot,
            one.diagnosis.message,
            one.simulated,
            one.robot_serial_number,
        )
        for one in await here.diagnoses.newest_of(LISTED, month)
    ]


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    from truepose.reports.diagnosis_report import DiagnosisInput

    record = await here.diagnoses.get(number)
    diagnosis = record.diagnosis
    if record.model_id is not None:
        diagnosis = replace(diagnosis, model=(await here.results.model(record.model_id)).model)
    campaign = await here.campaigns.get(record.campaign_id)
    named = words.between.join((campaign.name, measured_words(record.measured_at, words)))
    return Drawable(
        diagnosis_document(diagnosis),
        lambda spoken: _conditions(here, record, spoken),
        draw_diagnosis,
        lambda whole: DiagnosisInput(diagnosis, named, whole, words.tag),
    )


async def _conditions(here: Context, record: DiagnosisRecord, words: Catalogue) -> "ReportConditions":
    stated = await conditions_of_campaign(here, record.campaign_id, words)
    serial = stated.robot_serial_number or record.robot_serial_number
    return replace(stated, robot_serial_number=serial, measured_at=record.measured_at or "")


DIAGNOSIS = ReportKind("diagnosis", "reports.diagnosis", _rows, _drawable)
