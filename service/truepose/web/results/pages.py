"""Sessions for people: a list, each as it runs, what it came to, and forms that plan one."""

from dataclasses import dataclass
from functools import partial
from http import HTTPStatus
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, RedirectResponse, Response
from markupsafe import Markup

from truepose.domain.errors import TrueposeError
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.states import has_ended
from truepose.storage.records import ModelRecord, SessionRecord
from truepose.storage.work.items import WorkKind
from truepose.web.context import Context
from truepose.web.problems import status_of
from truepose.web.records.trail import missing, record_at, trail_of
from truepose.web.requests.parameters import WantedModel
from truepose.web.results.choices import Chosen
from truepose.web.results.kinds import Choice, Origin, ResultKind
from truepose.web.results.models import models_of
from truepose.web.results.origins import origin_of, origins_of
from truepose.web.results.registry import KINDS, kind_of
from truepose.web.results.states import STATES, state_words
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import Catalogue

router = APIRouter(prefix="/sessions", include_in_schema=False)
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


@router.get("", response_class=HTMLResponse)
async def sessions_page(visit: Visited) -> HTMLResponse:
    """List the latest sessions, each with its result once there is one."""
    origins = await origins_of(visit.here, await visit.here.sessions.newest(_SHOWN))
    rows = [_row(origin) for origin in origins]
    return visit.page("sessions/sessions.html", rows=rows, shown=_SHOWN)


@router.get("/new", response_class=HTMLResponse)
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


@router.get("/{id}", response_class=HTMLResponse)
async def session_page(visit: Visited, id: str) -> Response:
    """Show where a session stands, what it asks, and what a person may do."""
    origin = await record_at(id, partial(origin_of, visit.here))
    if origin is None:
        return missing(visit)
    record = origin.record
    if record.role == "ballbar" and not has_ended(record.state):
        return RedirectResponse(f"/operator/{record.id}")
    trail = await trail_of(visit, WorkKind.SESSION, record.id)
    return visit.page(
        "sessions/session_page.html",
        row=_row(origin),
        states=state_words(visit.words),
        trail=trail,
        ended=has_ended(record.state),
    )


@router.get("/{id}/result", response_class=HTMLResponse)
async def result_page(visit: Visited, id: str, choice: Chosen) -> HTMLResponse:
    """Show what a session came to."""
    origin = await record_at(id, partial(origin_of, visit.here))
    if origin is None:
        return missing(visit)
    row = _row(origin)
    shown = await _shown(visit.here, row, choice, visit.words)
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
class Shown:
    """The content of a result, or the sentence that says why there is none."""

    content: Markup | None
    why: str = ""
    status: HTTPStatus = HTTPStatus.OK
    models: tuple[ModelRecord, ...] = ()  # of which one may be chosen


async def _shown(here: Context, row: Row, choice: Choice, words: Catalogue) -> Shown:
    if row.kind is None:
        return Shown(None, words.say("result.of_no_kind"), HTTPStatus.NOT_FOUND)
    robot = (await here.sessions.setup(row.origin.record.id)).cell.robot.name
    models = tuple(await models_of(here, robot)) if row.kind.judges else ()
    try:
        return Shown(await row.kind.content(here, row.origin, choice, words), models=models)
    except TrueposeError as error:
        return Shown(None, str(error), status_of(error), models)


def _row(origin: Origin) -> Row:
    kind, record = kind_of(origin), origin.record
    title = _ROLES[record.role] if kind is None else kind.title
    return Row(origin, kind, title, STATES[record.state], kind is not None and record.measured > 0)
