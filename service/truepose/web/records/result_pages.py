"""Identifications and validations as their reports, and models."""

import asyncio
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.errors import TrueposeError
from truepose.domain.results.identification import Model
from truepose.exchange.exports.formats import FORMATS, Format, export
from truepose.storage.records import IdentificationRecord, ModelRecord, ValidationRecord
from truepose.storage.work.items import WorkKind
from truepose.web.records.trail import missing, record_at, trail_of
from truepose.web.reports.making import drawn_as_report
from truepose.web.reports.registry import KINDS
from truepose.web.visiting.drawn import Whole, drawn_part
from truepose.web.visiting.rendering import rendered
from truepose.web.visiting.visits import Visit, Visited
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from markupsafe import Markup

router = APIRouter(include_in_schema=False)


@router.get("/identifications/{id}", response_class=HTMLResponse)
async def identification_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show an identification as its report."""
    record = await record_at(id, visit.here.results.identification)
    return await _report_page(visit, record, WorkKind.IDENTIFICATION, whole=whole)


@router.get("/validations/{id}", response_class=HTMLResponse)
async def validation_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a validation as its report."""
    record = await record_at(id, visit.here.results.validation)
    return await _report_page(visit, record, WorkKind.VALIDATION, whole=whole)


async def _report_page(
    visit: Visit, record: IdentificationRecord | ValidationRecord | None, kind: WorkKind, *, whole: bool
) -> HTMLResponse:
    if record is None:
        return missing(visit)
    content = await drawn_as_report(visit, KINDS[kind.value], record.id, whole=whole)
    trail = await trail_of(visit, kind, record.id)
    return visit.page(f"results/{kind.value}.html", record=record, content=content, trail=trail)


@router.get("/models/{id}", response_class=HTMLResponse)
async def model_page(visit: Visited, id: str, whole: Whole = False) -> HTMLResponse:
    """Show a model: what it says of the robot, and the forms in which it can be taken."""
    record = await record_at(id, visit.here.results.model)
    if record is None:
        return missing(visit)
    of = f"model {record.id} {record.recorded_at}"
    told = await drawn_part(visit, of, lambda: asyncio.to_thread(_told, record, visit.words), whole=whole)
    trail = await trail_of(visit, WorkKind.MODEL, record.id)
    return visit.page("results/model.html", record=record, told=told, trail=trail)


@dataclass(frozen=True, slots=True)
class ShownModel:
    """What the page shows of a model."""

    rows: "tuple[tuple[str, str, str, str, str], ...]"  # name, value, uncertainty, unit, meaning
    effects: tuple[str, ...]
    exports: tuple[tuple[Format, str], ...]  # and why the model has no such form; empty: it has
    correlation: "Markup | None"


def _told(record: ModelRecord, words: Catalogue) -> str:
    shown = _model(record, words)
    return rendered("results/model_told.html", record=record, shown=shown, words=words, say=words.say)


def _model(record: ModelRecord, words: Catalogue) -> ShownModel:
    from truepose.reports.figures.maps.correlation import correlation_map
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
