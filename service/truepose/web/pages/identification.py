"""Identifications, validations and models: their pages, and the reports of the first two."""

import asyncio
from dataclasses import replace

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.errors import TrueposeError, text_of
from truepose.domain.identification import Model
from truepose.exchange.models.exports import FORMATS, Format, export
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message
from truepose.storage.records import IdentificationRecord, ModelRecord, ValidationRecord
from truepose.storage.results.items import WorkItem, WorkKind
from truepose.validation.outcome import outcome_of
from truepose.web.context import Context
from truepose.web.drawn_reports import StoredIdentification, StoredValidation
from truepose.web.pages.conditions import conditions_of_result
from truepose.web.pages.records import record_at, trail_of
from truepose.web.pages.rendering import Visit, Visited, Whole, render, render_part
from truepose.web.pages.report_kinds import LISTED, Drawable, ReportKind, ReportRow, report_page
from truepose.web.pages.session_results import Choice

router = APIRouter(include_in_schema=False)


@router.get("/identifications/{id}", response_class=HTMLResponse)
async def identification_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show an identification as its report."""
    record = await record_at(id, visit.here.results.identification)
    return await _report_page(visit, record, IDENTIFICATION, whole=whole)


@router.get("/validations/{id}", response_class=HTMLResponse)
async def validation_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a validation as its report."""
    record = await record_at(id, visit.here.results.validation)
    return await _report_page(visit, record, VALIDATION, whole=whole)


async def _report_page(
    visit: Visit,
    record: IdentificationRecord | ValidationRecord,
    report: ReportKind,
    *,
    whole: bool,
) -> HTMLResponse:
    found = record.identification if isinstance(record, IdentificationRecord) else record.validation
    return visit.page(
        f"results/{report.name}.html",
        record=record,
        outcome=outcome_of(found),
        content=await report_page(visit, report, record.id, whole=whole),
        trail=await trail_of(visit, WorkKind(report.name), record.id),
    )


@router.get("/models/{id}", response_class=HTMLResponse)
async def model_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a model: what it says of the robot, and the forms in which it can be taken."""
    record = await record_at(id, visit.here.results.model)
    of = f"model {record.id} {record.recorded_at}"
    told = await render_part(
        visit, of, lambda: asyncio.to_thread(_rendered, record, visit.words), whole=whole
    )
    trail = await trail_of(visit, WorkKind.MODEL, record.id)
    outcome = await _outcome(visit, record, trail.lineage.newest(WorkKind.VALIDATION))
    return visit.page("results/model.html", record=record, outcome=outcome, told=told, trail=trail)


async def _outcome(visit: Visit, record: ModelRecord, judged: WorkItem | None) -> Message | None:
    """Return what a model came to where it was judged last; None of one that was handed down unjudged."""
    here = visit.here
    if judged is not None:
        return outcome_of((await here.results.validation(judged.id)).validation)
    if record.diagnosis_id is not None:
        return outcome_of((await here.diagnoses.get(record.diagnosis_id)).diagnosis)
    if record.identification_id is not None:
        return outcome_of((await here.results.identification(record.identification_id)).identification)
    return None


def _rendered(record: ModelRecord, words: Catalogue) -> str:
    from truepose.reports.identification.observability import correlation_map
    from truepose.reports.identification.parameters import model_table

    model = record.model
    return render(
        "results/model_told.html",
        record=record,
        parameters=model_table(model, words),
        effects=[words.effect(name) for name in model.effects],
        exports=[
            (form, _refusal(model, form, words)) for form in FORMATS
        ],  # and why it has no such form; empty: it has
        correlation=correlation_map(model, words),
        words=words,
        say=words.say,
    )


def _refusal(model: Model, form: Format, words: Catalogue) -> str:
    """Return why a model has no such form; empty: it has."""
    try:
        export(model, form)
    except TrueposeError as error:
        return words.spoken(text_of(error))
    return ""


async def _identification_rows(here: Context, month: str) -> list[ReportRow]:
    records = await here.results.newest_identifications(LISTED, month)
    return [IDENTIFICATION.row(one, one.robot, outcome_of(one.identification)) for one in records]


async def _identification(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    record = await here.results.identification(number)
    found = record.identification
    if record.model_id is not None:
        found = replace(found, model=(await here.results.model(record.model_id)).model)
    content = await here.campaigns.content(record.campaign_id)
    return Drawable(
        record.id,
        lambda spoken: conditions_of_result(here, record.campaign_id, record.recorded_at, spoken),
        lambda whole: StoredIdentification(found, content, whole, words.tag),
    )


IDENTIFICATION = ReportKind("identification", "reports.identification", _identification_rows, _identification)


async def _validation_rows(here: Context, month: str) -> list[ReportRow]:
    records = await here.results.newest_validations(LISTED, month)
    robots = {one.model_id: (await here.results.model(one.model_id)).robot for one in records}
    return [VALIDATION.row(one, robots[one.model_id], outcome_of(one.validation)) for one in records]


async def _validation(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    record = await here.results.validation(number)
    model = (await here.results.model(record.model_id)).model
    content = await here.campaigns.content(record.campaign_id)
    return Drawable(
        record.id,
        lambda spoken: conditions_of_result(here, record.campaign_id, record.recorded_at, spoken),
        lambda whole: StoredValidation(record.validation, model, content, whole, words.tag),
    )


VALIDATION = ReportKind("validation", "reports.validation", _validation_rows, _validation)
