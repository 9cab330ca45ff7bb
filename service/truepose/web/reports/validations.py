"""Reports of validations."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from truepose.analysis.workers.tasks import held_out, stored_campaign
from truepose.exchange.results.validation import validation_document
from truepose.web.context import Context
from truepose.web.reports.conditions import conditions_of_campaign
from truepose.web.reports.kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.results.kinds import Choice
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.domain.results.identification import Model
    from truepose.domain.results.validation import Validation
    from truepose.reports.traceability.conditions import ReportConditions


@dataclass(frozen=True, slots=True)
class StoredValidation:
    """A validation with what it is of, as it is stored: unpacked where the report is drawn."""

    validation: "Validation"
    model: "Model"
    campaign: bytes
    conditions: "ReportConditions"
    language: str


def draw_validation(stored: StoredValidation) -> str:
    """Return the report as a page."""
    from truepose.judgement.cautions import validation_cautions
    from truepose.reports.validation.report import ValidationInput, validation_page

    readings = held_out(stored_campaign(stored.campaign))
    remarks = tuple(validation_cautions(stored.model, readings))
    return validation_page(
        ValidationInput(
            stored.validation,
            stored.model,
            readings,
            remarks,
            conditions=stored.conditions,
            language=stored.language,
        )
    )


async def _rows(here: Context, month: str) -> list[ReportRow]:
    from truepose.reports.validation.sentences import verdict_sentence

    records = await here.results.newest_validations(LISTED, month)
    robots = {one.model_id: (await here.results.model(one.model_id)).robot for one in records}
    return [
        ReportRow(
            "validation",
            one.id,
            "reports.validation",
            one.recorded_at,
            robots[one.model_id],
            verdict_sentence(one.validation),
            one.simulated,
        )
        for one in records
    ]


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    record = await here.results.validation(number)
    model = (await here.results.model(record.model_id)).model
    content = await here.campaigns.content(record.campaign_id)
    return Drawable(
        validation_document(record.validation),
        lambda spoken: conditions_of_campaign(here, record.campaign_id, spoken),
        draw_validation,
        lambda whole: StoredValidation(record.validation, model, content, whole, words.tag),
    )


VALIDATION = ReportKind("validation", "reports.validation", _rows, _drawable)
