"""Sessions: a list, each as it runs, its result and its report, how it is closed, and forms that plan one."""

import asyncio
import hashlib
import pickle
from dataclasses import dataclass, replace
from functools import partial
from http import HTTPStatus
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from markupsafe import Markup

from truepose.domain.errors import TrueposeError, text_of
from truepose.domain.session import SessionState
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import message
from truepose.sessions.engine.states import has_ended
from truepose.storage.errors import ConflictError
from truepose.storage.records import ModelRecord, SessionRecord
from truepose.storage.results.items import WorkKind
from truepose.web.context import Context
from truepose.web.pages.accuracy_results import ACCURACY, POSE_TEST, PROOF
from truepose.web.pages.conditions import closing_sentence, conditions_of_sessions
from truepose.web.pages.geometry_results import CIRCLES, SPHERE
from truepose.web.pages.next_action import identify_and_diagnose
from truepose.web.pages.records import record_at, session_states, state_look, trail_of
from truepose.web.pages.rendering import Visit, Visited, render_part
from truepose.web.pages.report_kinds import LISTED, Drawable, ReportKind, ReportRow
from truepose.web.pages.session_results import (
    Choice,
    Chosen,
    Origin,
    ResultKind,
    models_of,
    origin_of,
    origins_of,
)
from truepose.web.problems import status_of
from truepose.web.resources import Id, WantedModel

KINDS: Final[tuple[ResultKind, ...]] = (PROOF, POSE_TEST, CIRCLES, SPHERE, ACCURACY)


def kind_of(origin: Origin) -> ResultKind | None:
    """Return the kind of result that a session gives; None: its readings are for something else."""
    return next((kind for kind in KINDS if kind.is_of(origin)), None)


router = APIRouter(include_in_schema=False)
_SHOWN: Final = 50
_OFFERED: Final = 6  # to be planned as last time
_ROLES: Final = {
    "calibration": "session.calibration",
    "validation": "session.validation",
    "ballbar": "session.ballbar",
    "contacts": "session.contacts",
}


@dataclass(frozen=True, slots=True)
class Row:
    """A session as pages name it."""

    origin: Origin
    kind: ResultKind | None
    title: str  # key of the catalogue
    state: str  # key of the catalogue
    has_result: bool


@router.get("/sessions", response_class=HTMLResponse)
async def sessions_page(visit: Visited) -> HTMLResponse:
    """List the latest sessions, each with its result once there is one."""
    origins = await origins_of(visit.here, await visit.here.sessions.newest(_SHOWN))
    rows = [_row(origin) for origin in origins]
    return visit.page("sessions/sessions.html", rows=rows, shown=_SHOWN)


@router.get("/sessions/new", response_class=HTMLResponse)
async def new_session_page(visit: Visited, wanted: WantedModel = None) -> HTMLResponse:
    """Show a form for each kind of session that is planned from a page; `wanted` is the model to prove."""
    models = await models_of(visit.here, visit.here.cell.robot.name)
    forms = [(kind, kind.form(visit.here)) for kind in KINDS if kind.form is not None]
    recent = await _measured_before(visit.here)
    return visit.page("sessions/new_session.html", forms=forms, models=models, wanted=wanted, recent=recent)


async def _measured_before(here: Context) -> list[SessionRecord]:
    """Return the latest sessions that may be planned once more, each name once."""
    found = [one for one in await here.sessions.newest(_SHOWN) if one.state is SessionState.FINISHED]
    by_name = {one.name: one for one in reversed(found)}
    return sorted(by_name.values(), key=lambda one: -one.id)[:_OFFERED]


@router.get("/sessions/{id}", response_class=HTMLResponse)
async def session_page(visit: Visited, id: str) -> Response:
    """Show where a session stands, what it asks, and what a person may do."""
    origin = await record_at(id, partial(origin_of, visit.here))
    record = origin.record
    if visit.here.session_desk.kind_of(record).shown_on_tablet and not has_ended(record.state):
        return RedirectResponse(f"/operator/{record.id}")
    trail = await trail_of(visit, WorkKind.SESSION, record.id)
    return visit.page(
        "sessions/session_page.html",
        row=_row(origin),
        states=session_states(visit.words),
        trail=trail,
        so_far=identify_and_diagnose(record.id, record.name),
        ended=has_ended(record.state),
    )


@router.get("/sessions/{id}/result", response_class=HTMLResponse)
async def result_page(visit: Visited, id: str, choice: Chosen) -> HTMLResponse:
    """Show what a session came to."""
    origin = await record_at(id, partial(origin_of, visit.here))
    row = _row(origin)
    shown = await _result(visit, row, choice)
    trail = await trail_of(visit, WorkKind.SESSION, origin.record.id)
    return visit.page(
        "results/result.html",
        shown.status,
        row=row,
        shown=shown,
        choice=choice,
        trail=trail,
        ended=has_ended(origin.record.state),
    )


@dataclass(frozen=True, slots=True)
class ResultContent:
    """The content of a result, or the sentence that says why there is none."""

    content: Markup | None
    why: str = ""
    status: HTTPStatus = HTTPStatus.OK
    models: tuple[ModelRecord, ...] = ()  # of which one may be chosen


async def _result(visit: Visit, row: Row, choice: Choice) -> ResultContent:
    here, words = visit.here, visit.words
    if row.kind is None:
        return ResultContent(None, words.say("result.of_no_kind"), HTTPStatus.NOT_FOUND)
    robot = (await here.sessions.setup(row.origin.record.id)).cell.robot.name
    models = tuple(await models_of(here, robot)) if row.kind.judges else ()
    try:
        report = await row.kind.report(here, row.origin, choice, words)
        # All that the content follows from: a session under way has another report after each reading.
        of = f"result {hashlib.sha256(pickle.dumps(report)).hexdigest()}"
        content = await render_part(visit, of, lambda: asyncio.to_thread(report.content), whole=True)
        return ResultContent(content, models=models)
    except TrueposeError as error:
        return ResultContent(None, words.spoken(text_of(error)), status_of(error), models)


def _row(origin: Origin) -> Row:
    kind, record = kind_of(origin), origin.record
    title = _ROLES[record.role] if kind is None else kind.title
    return Row(
        origin,
        kind,
        title,
        state_look(WorkKind.SESSION, record.state)[1],
        kind is not None and record.measured > 0,
    )


@router.get("/sessions/{id}/closing", response_class=HTMLResponse)
async def closing_page(visit: Visited, id: Id) -> HTMLResponse:
    """Show what a session was closed as, or a form that closes it."""
    here = visit.here
    record, closing = await here.sessions.get(id), await here.closings.of_session(id)
    papers = closing.certificates if closing else await here.closing_desk.certificates(id)
    return visit.page(
        "sessions/closing.html",
        place="work",
        record=record,
        closing=closing,
        sentence=visit.words.spoken(closing_sentence(closing)),
        papers=papers,
        faults=[visit.words.spoken(one.fault) for one in papers if not one.proves],
    )


async def _report_rows(here: Context, month: str) -> list[ReportRow]:
    origins = await origins_of(here, await here.sessions.newest_of(LISTED, month))
    return [await _report_row(here, row) for row in map(_row, origins) if row.has_result]


async def _report_row(here: Context, row: Row) -> ReportRow:
    record = row.origin.record
    cell = (await here.sessions.setup(record.id)).cell
    return SESSION.row(record, cell.robot.name, record.name, cell.robot_serial_number, row.title)


async def _drawable(here: Context, number: int, choice: Choice, words: Catalogue) -> Drawable:
    origin = await origin_of(here, number)
    kind = kind_of(origin)
    if kind is None:
        raise ConflictError(message("refused.identifying_session"))
    report = await kind.report(here, origin, choice, words)
    return Drawable(
        (number, choice, await here.sessions.chain_head(number)),
        lambda spoken: conditions_of_sessions(here, [number], spoken),
        lambda whole: replace(report, conditions=whole),
    )


SESSION = ReportKind("session", "reports.session", _report_rows, _drawable)
