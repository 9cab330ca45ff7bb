"""The cell: what it is, what runs, what is wrong, and the one next step."""

from dataclasses import dataclass
from datetime import UTC, date, datetime
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.operation.devices import DeviceStatus
from truepose.sequencing.engine.states import has_ended
from truepose.storage.records import JobRecord, SessionRecord
from truepose.storage.work.items import WorkKind
from truepose.web.context import Context
from truepose.web.places.next_step import Standing, Step, next_step
from truepose.web.records.links import link_to, state_words
from truepose.web.reports.expiry import expiry_warnings
from truepose.web.visiting.visits import Visited

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
            (one, *state_words(WorkKind.SESSION, one.state)) for one in sessions if not has_ended(one.state)
        ],
        jobs=jobs,
        instruments=[_instrument(status) for status in here.rack.statuses()],
        troubles=[told for told in (here.fault(),) if told],
        certificates=[visit.words.spoken(one) for one in expiry_warnings(here.cell, _today())],
        latest=[link_to(item, visit.words) for item in latest.items],
    )


def _today() -> date:
    return datetime.now(UTC).date()


async def _step(here: Context, sessions: list[SessionRecord], jobs: list[JobRecord]) -> Step:
    statuses = here.rack.statuses()
    lineage = await here.lineages.of(WorkKind.SESSION, sessions[0].id) if sessions else None
    return next_step(
        Standing(
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
