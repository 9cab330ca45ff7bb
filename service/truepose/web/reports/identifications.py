"""Reports of identifications."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from truepose.analysis.workers.tasks import stored_campaign
from truepose.exchange.results.identification import identification_document
from truepose.web.context import Context
from truepose.web.reports.conditions import conditions_of_campaign
from truepose.web.reports.kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.results.kinds import Choice
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.domain.results.identification import Identification
    from truepose.reports.traceability.conditions import ReportConditions


@dataclass(frozen=True, slots=True)
class StoredIdentification:
    """An identification with its campaign as it is stored: unpacked where the report is drawn."""

    identification: "Identification"
    campaign: bytes
    conditions: "ReportConditions"
    language: str


def draw_identification(stored: StoredIdentification) -> str:
    """Return the report as a page."""
    from truepose.reports.identification_report import ReportInput, identification_page

    campaign = stored_campaign(stored.campaign)
    report = ReportInput(stored.identification, campaign, stored.conditions, language=stored.language)
    return identification_page(report)


async def _rows(here: Context, month: str) -> list[ReportRow]:
    return [
        ReportRow(
            "identification",
            one.id,
            "reports.identification",
            one.recorded_at,
            one.robot,
            one.identification.message,
            one.simulated,
        )
        for one in await here.results.newest_identifications(LISTED, month)
    ]


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    record = await here.results.identification(number)
    found = record.identification
    if record.model_id is not None:
        found = replace(found, model=(await here.results.model(record.model_id)).model)
    content = await here.campaigns.content(record.campaign_id)
    return Drawable(
        identification_document(found, record.robot),
        lambda spoken: conditions_of_campaign(here, record.campaign_id, spoken),
        draw_identification,
        lambda whole: StoredIdentification(found, content, whole, words.tag),
    )


IDENTIFICATION = ReportKind("identification", "reports.identification", _rows, _drawable)
