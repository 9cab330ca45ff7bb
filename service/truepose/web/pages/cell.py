"""The cell: what it is and does, the one next step, its simulated faults, and what the plant handed down."""

import asyncio
import math
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, date, datetime
from functools import partial
from typing import Annotated, Any, Final

from fastapi import APIRouter, Query
from fastapi.responses import HTMLResponse

from truepose.domain.cell import Cell
from truepose.domain.errors import UnsuitableModelError, text_of
from truepose.exchange.models.acceptance import HandedModel, fitting_model
from truepose.messages.catalogue import Catalogue
from truepose.sessions.devices import DeviceStatus
from truepose.sessions.engine.states import has_ended
from truepose.storage.plant.deployments import HandedDownRecord, HandedDownRepository
from truepose.storage.records import JobRecord, SessionRecord
from truepose.storage.results.items import WorkKind
from truepose.web.context import Context
from truepose.web.pages.conditions import expiry_warnings
from truepose.web.pages.next_action import CellProgress, NextAction, next_action
from truepose.web.pages.records import link_to, state_look
from truepose.web.pages.rendering import Visited, moment
from truepose.web.schemas import NUMBER_LIMIT
from truepose_drivers.errors import DriverError

router = APIRouter(include_in_schema=False)
_LATEST: Final = 5
_UNDER_WAY: Final = 20  # jobs that are looked at


@dataclass(frozen=True, slots=True)
class Instrument:
    """A device as the page shows it."""

    name: str
    role: str  # key of the catalogue
    look: str
    state: str  # key of the catalogue
    identity: str
    fault: str
    expected: str  # serial number that the cell file names, where another device answers; else empty


@router.get("/", response_class=HTMLResponse)
async def cell_page(visit: Visited) -> HTMLResponse:
    """Show the cell, what it does, what is wrong with it, and what to do next."""
    here = visit.here
    jobs = [job for job in await here.jobs.newest(_UNDER_WAY) if not job.state.final]
    sessions = await here.sessions.newest(1)
    latest = await here.work.page(list(WorkKind), limit=_LATEST)
    return visit.page(
        "cell.html",
        step=await _step(here, sessions, jobs),
        sessions=[
            (one, *state_look(WorkKind.SESSION, one.state)) for one in sessions if not has_ended(one.state)
        ],
        jobs=jobs,
        instruments=[_instrument(status) for status in here.rack.statuses()],
        troubles=[told for told in (here.fault(),) if told],
        certificates=[visit.words.spoken(one) for one in expiry_warnings(here.cell, _today())],
        latest=[link_to(item, visit.words) for item in latest.items],
    )


def _today() -> date:
    return datetime.now(UTC).date()


async def _step(here: Context, sessions: list[SessionRecord], jobs: list[JobRecord]) -> NextAction:
    statuses = here.rack.statuses()
    lineage = await here.lineages.of(WorkKind.SESSION, sessions[0].id) if sessions else None
    return next_action(
        CellProgress(
            devices=tuple(status.mounted.entry.name for status in statuses),
            connected=sum(status.connected for status in statuses),
            session=None if lineage is None else lineage.item(WorkKind.SESSION, sessions[0].id),
            lineage=lineage,
            job_id=jobs[0].id if jobs else None,
        )
    )


def _instrument(status: DeviceStatus) -> Instrument:
    look, state = _link_of(status)
    known = status.identity
    told = () if known is None else (known.manufacturer, known.model, known.serial)
    return Instrument(
        name=status.mounted.entry.name,
        role=status.mounted.entry.driver,
        look=look,
        state=state,
        identity=" ".join(filter(None, told)),
        fault="" if status.connected else status.fault or "",
        expected=(status.mounted.expected_serial or "") if status.is_foreign else "",
    )


def _link_of(status: DeviceStatus) -> tuple[str, str]:
    if status.is_foreign:
        return "warn", "cell.link.foreign"
    if status.connected:
        return ("busy", "cell.link.in_use") if status.session_id else ("good", "cell.link.connected")
    return ("bad", "cell.link.fault") if status.fault else ("idle", "cell.link.none")


_HANDED_DOWN: Final = 10  # each model among them is checked, which takes some tenths of a second
Before = Annotated[
    int | None, Query(ge=1, le=NUMBER_LIMIT, description="Include plans and models pushed earlier.")
]


@router.get("/hand-downs", response_class=HTMLResponse)
async def handed_down_page(visit: Visited, before: Before = None) -> HTMLResponse:
    """List what was handed down, the latest first, with who accepted or used it."""
    found = await HandedDownRepository(visit.here.database).newest(_HANDED_DOWN + 1, before)
    shown = found[:_HANDED_DOWN]
    checks = await asyncio.to_thread(_checks, shown, visit.here.cell, visit.words)
    return visit.page(
        "results/hand_downs.html",
        hand_downs=shown,
        older=shown[-1].id if len(found) > _HANDED_DOWN else None,
        checks=checks,
        moment=moment,
        joints=partial(_joints, words=visit.words),
    )


def _checks(found: Iterable[HandedDownRecord], cell: Cell, words: Catalogue) -> dict[int, HandedModel | str]:
    """Return what each model that waits for acceptance does here, or why it is none for this cell."""
    waiting = (one for one in found if one.handed_down.kind == "model" and one.model_id is None)
    return {one.id: _check(one, cell, words) for one in waiting}


def _check(record: HandedDownRecord, cell: Cell, words: Catalogue) -> HandedModel | str:
    try:
        return fitting_model(record.handed_down.document, cell)
    except UnsuitableModelError as error:
        return words.spoken(text_of(error))


def _joints(handed: HandedModel, words: Catalogue) -> str:
    angles = (words.units.formatted(math.degrees(angle), ".1f", "") for angle in handed.shift.joints_rad)
    return ", ".join(f"{angle}°" for angle in angles)


_WHEN: Final = {"from_s", "configuration", "move", "reading", "after_s", "for_s", "until_s", "count"}


@router.get("/faults", response_class=HTMLResponse)
async def faults_page(visit: Visited) -> HTMLResponse:
    """Show what goes wrong in the cell, and what may."""
    desk = visit.here.faults_desk
    try:
        kinds = await desk.kinds() if desk.simulated else []
    except DriverError:  # the cell has ended: the page says so
        kinds = []
    return visit.page(
        "faults.html",
        simulated=desk.simulated,
        kinds=[_form_of(kind) for kind in kinds],
        names={kind["kind"]: visit.words.name(kind["kind"]) for kind in kinds},
    )


def _form_of(kind: dict[str, Any]) -> dict[str, Any]:
    keys = {key["key"]: key for key in kind["keys"]}
    own = [key for name, key in keys.items() if name not in _WHEN]
    return {"kind": kind["kind"], "own": own, "lasts": "for_s" in keys}
