"""Identifications, validations and models, each as its report.

Reports are imported where a page is made, as their drawing library takes most of a second.
"""

import asyncio
import dataclasses
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.analysis.workers.tasks import held_out, stored_campaign
from truepose.domain.errors import TrueposeError
from truepose.domain.results import Model
from truepose.exchange.exports.formats import FORMATS, Format, export
from truepose.storage.errors import NotFoundError
from truepose.storage.records import CampaignRecord, IdentificationRecord, ModelRecord, ValidationRecord
from truepose.storage.work.items import WorkKind
from truepose.web.context import Context
from truepose.web.moments import moment
from truepose.web.parameters import number_of
from truepose.web.records.trail import missing, trail_of
from truepose.web.visits import Visited
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from markupsafe import Markup

    from truepose.reports import ReportConditions

router = APIRouter(include_in_schema=False)
R = TypeVar("R")


@router.get("/identifications/{id}", response_class=HTMLResponse)
async def identification_page(visit: Visited, id: str) -> HTMLResponse:
    """Show an identification as its report."""
    here = visit.here
    record = await _found(id, here.results.identification)
    if record is None:
        return missing(visit)
    content = await _identification(here, record, visit.words)
    trail = await trail_of(visit, WorkKind.IDENTIFICATION, record.id)
    return visit.page("identification.html", record=record, content=content, trail=trail)


@router.get("/validations/{id}", response_class=HTMLResponse)
async def validation_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a validation as its report."""
    here = visit.here
    record = await _found(id, here.results.validation)
    if record is None:
        return missing(visit)
    content = await _validation(here, record, visit.words)
    trail = await trail_of(visit, WorkKind.VALIDATION, record.id)
    return visit.page("validation.html", record=record, content=content, trail=trail)


@router.get("/models/{id}", response_class=HTMLResponse)
async def model_page(visit: Visited, id: str) -> HTMLResponse:
    """Show a model: what it says of the robot, and the forms in which it can be taken."""
    record = await _found(id, visit.here.results.model)
    if record is None:
        return missing(visit)
    shown = await asyncio.to_thread(_model, record, visit.words)
    trail = await trail_of(visit, WorkKind.MODEL, record.id)
    return visit.page("model.html", record=record, shown=shown, trail=trail)


async def _found(id: str, get: Callable[[int], Awaitable[R]]) -> R | None:
    """Return the record of a number in an address; None where it names none."""
    number = number_of(id)
    if number is None:
        return None
    try:
        return await get(number)
    except NotFoundError:
        return None


async def _identification(here: Context, record: IdentificationRecord, words: Catalogue) -> "Markup":
    from truepose.reports import ReportInput, identification_content

    found = record.identification
    if record.model_id is not None:
        found = dataclasses.replace(found, model=(await here.results.model(record.model_id)).model)
    kept, conditions = await _campaign(here, record.campaign_id, record.recorded_at)
    campaign = await asyncio.to_thread(stored_campaign, await here.campaigns.content(kept.id))
    report = ReportInput(found, campaign, conditions, language=words.language)
    return await asyncio.to_thread(identification_content, report)


async def _validation(here: Context, record: ValidationRecord, words: Catalogue) -> "Markup":
    from truepose.judgement.cautions import validation_cautions
    from truepose.reports import ValidationInput, validation_content

    model = (await here.results.model(record.model_id)).model
    kept, conditions = await _campaign(here, record.campaign_id, record.recorded_at)
    campaign = await asyncio.to_thread(stored_campaign, await here.campaigns.content(kept.id))
    readings = held_out(campaign)
    remarks = tuple(validation_cautions(model, readings))
    report = ValidationInput(
        record.validation, model, readings, remarks, conditions=conditions, language=words.language
    )
    return await asyncio.to_thread(validation_content, report)


async def _campaign(here: Context, number: int, written: str) -> "tuple[CampaignRecord, ReportConditions]":
    """Return the campaign of a result, and what is known of how it was measured."""
    from truepose.reports import ReportConditions

    kept = await here.campaigns.get(number)
    serial = ""
    if kept.session_ids:
        serial = (await here.sessions.setup(kept.session_ids[0])).cell.robot_serial_number
    stated = ReportConditions(
        simulated=kept.simulated,
        robot_serial_number=serial,
        written_at=moment(written),
        notes=kept.summary.notes,
    )
    return kept, stated


@dataclass(frozen=True, slots=True)
class ShownModel:
    """What the page shows of a model."""

    rows: "tuple[tuple[str, str, str, str, str], ...]"  # name, value, uncertainty, unit, meaning
    effects: tuple[str, ...]
    exports: tuple[tuple[Format, str], ...]  # and why the model has no such form; empty: it has
    correlation: "Markup | None"


def _model(record: ModelRecord, words: Catalogue) -> ShownModel:
    from truepose.reports.figures.correlation import correlation_map
    from truepose.reports.parameters.rows import model_rows

    model = record.model
    effects = tuple(words.effect(name) for name in model.effects)
    exports = tuple((form, _refusal(model, form)) for form in FORMATS)
    return ShownModel(model_rows(model, words), effects, exports, correlation_map(model, words))


def _refusal(model: Model, form: Format) -> str:
    try:
        export(model, form)
    except TrueposeError as error:
        return str(error)
    return ""
