"""A session repeated: what its plan takes over, what is different now, and what came of it before."""

from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from typing import Annotated, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.session import SessionPlan
from truepose.messages.catalogue import Catalogue
from truepose.sessions.cell import differences
from truepose.storage.errors import NotFoundError
from truepose.storage.records import SessionRecord
from truepose.storage.results.items import WorkKind
from truepose.web.api.repeat_session import Template, template_of
from truepose.web.context import Context
from truepose.web.pages.conditions import expiry_warnings
from truepose.web.pages.records import Link, link_to, record_at
from truepose.web.pages.rendering import Visit, Visited

router = APIRouter(prefix="/sessions", include_in_schema=False)
Some = Annotated[tuple[int, ...], Query(description="Only these; none: all.")]
_LOOKED_THROUGH: Final = 200  # of the latest sessions of a kind
_SHOWN: Final = 8
_MEASURED_BY: Final = {"ballbar": "again.by.ballbar", "contacts": "again.by.contacts"}


@dataclass(frozen=True, slots=True)
class EarlierSession:
    """A session of the same kind and size, and the error that its model left on held-out readings."""

    link: Link
    held_out: str  # with its unit; "" where nothing was identified from it


@router.get("/{id}/again", response_class=HTMLResponse)
async def again_page(visit: Visited, id: str, configurations: Some = ()) -> HTMLResponse:
    """Show what is taken over from a session, what is different now, and a form that plans it once more."""
    template = await record_at(id, partial(template_of, visit.here))
    template = template.of_configurations(configurations) if configurations else template
    now, words = visit.here.cell, visit.words
    same_robot = template.then.cell.robot.name == now.robot.name
    warnings = (*differences(template.then.cell, now), *expiry_warnings(now, datetime.now(UTC).date()))
    return visit.page(
        "sessions/again.html",
        once=template,
        record=template.record,
        same_robot=same_robot,
        only=configurations,
        taken=tuple(_taken_over(template, words)),
        warnings=[words.spoken(one) for one in warnings],
        earlier=await _history(visit, template),
    )


def _taken_over(template: Template, words: Catalogue) -> list[tuple[str, str]]:
    """Return what the new session has of the earlier one, each with its name."""
    say, cell, plan = words.say, template.then.cell, template.plan
    told = [
        (say("report.robot"), f"{cell.robot.name} {cell.robot_serial_number}".strip()),
        (say("again.instrument"), say(_instrument(template))),
        (say("again.configurations"), str(template.configurations)),
        (say("again.attachment"), str(template.then.attachment)),
    ]
    if isinstance(plan, SessionPlan):
        nests = dict.fromkeys(str(stop.nest) for stop in plan.stops)
        told += [
            (say("again.revisits"), str(len(plan.stops) - template.configurations)),
            (say("again.nests"), words.listed(tuple(nests), "commas")),
            (say("again.settle"), f"{plan.settle_s:g} s, {plan.measure_s:g} s"),
        ]
    if isinstance(plan, BallbarPlan):
        cups = len(plan.placements[0].cups_mm)
        told += [(say("again.placements"), str(len(plan.placements))), (say("again.cups"), str(cups))]
    return told


def _instrument(template: Template) -> str:
    """Return the key of what measured."""
    if template.record.role in _MEASURED_BY:
        return _MEASURED_BY[template.record.role]
    return "again.by.camera" if template.then.cell.camera else "again.by.tracker"


async def _history(visit: Visit, template: Template) -> list[EarlierSession]:
    """Return sessions of the same kind and size, newest first: with the same plan, or one like it."""
    found = await visit.here.sessions.newest(_LOOKED_THROUGH)
    alike = [one for one in found if _is_alike(one, template.record)]
    return [await _earlier(visit, one) for one in alike[:_SHOWN]]


def _is_alike(one: SessionRecord, record: SessionRecord) -> bool:
    return (one.role, one.test, one.planned) == (record.role, record.test, record.planned)


async def _earlier(visit: Visit, record: SessionRecord) -> EarlierSession:
    lineage = await visit.here.lineages.of(WorkKind.SESSION, record.id)
    session, made = lineage.item(WorkKind.SESSION, record.id), lineage.newest(WorkKind.IDENTIFICATION)
    if session is None:
        raise NotFoundError("session", record.id)
    error = "" if made is None else await _held_out(visit.here, made.id, visit.words)
    return EarlierSession(link_to(session, visit.words), error)


async def _held_out(here: Context, identification_id: int, words: Catalogue) -> str:
    from truepose.reports.rounding import millimetres

    found = (await here.results.identification(identification_id)).identification
    held_out = found.validation or found.cross_validation
    return "" if held_out is None else words.units.quantity(millimetres(held_out.identified.mean_mm), "mm")
