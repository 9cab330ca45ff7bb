"""Pages of the plant at a glance, and of each cell: who is due and why, what changed, visits and chains."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from http import HTTPStatus
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.cell import Standing
from truepose.plant.calibration_due import DueReason, RobotStatus, latest_day
from truepose.plant.changes import RecordedChange, RobotChanged
from truepose.plant.outcome import plant_outcome
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.overview import RobotMeasured
from truepose.storage.plant.records import Outcome, Visit
from truepose.web.pages.rendering import Visited, moment
from truepose.web.plant.changes import since_a_week
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.links import Places, cell_links, due_robot, places_of, result_links, standing
from truepose.web.resources import Name

router = APIRouter(include_in_schema=False)
_NEXT: Final = 20  # robots to be measured, and that changed, and what came in: what is read at a glance
_CURRENT: Final = "current"
_STATES: Final[Mapping[str, tuple[str, str]]] = {  # how a badge looks, and what it says
    _CURRENT: ("good", "plant.state.current"),
    DueReason.UNMEASURED: ("warn", "plant.state.unmeasured"),
    DueReason.DOUBTFUL: ("warn", "plant.state.doubtful"),
    DueReason.FAILED: ("bad", "plant.state.failed"),
    DueReason.UNDECIDED: ("warn", "plant.state.undecided"),
    DueReason.WORSE: ("warn", "plant.state.worse"),
    DueReason.UNCERTIFIED: ("bad", "plant.state.uncertified"),
    DueReason.CHANGED: ("warn", "plant.state.changed"),
    DueReason.UNEXPLAINED: ("warn", "plant.state.unexplained"),
    DueReason.WORSENING: ("warn", "plant.state.worsening"),
    DueReason.OVERDUE: ("warn", "plant.state.overdue"),
    DueReason.ASKED: ("warn", "plant.state.asked"),
}


@dataclass(frozen=True, slots=True)
class ChangedRobot:
    """A robot of which something changed, and each change with the page of the record that says so."""

    of: RobotMeasured
    changes: Sequence[tuple[RecordedChange, str]]


@router.get("/", response_class=HTMLResponse)
async def plant_page(visit: Visited, here: PlantHere) -> HTMLResponse:
    """Show who is to be measured next and why, how robots stand, what changed, and the cells.

    Nothing is computed for it: two states that are kept in memory are compared, and forecasts are those of
    the last look at `/fleet` (decision 0069).
    """
    today = datetime.now(UTC).date()
    papers, places = await here.certificates.that_count(), await places_of(here)
    measured = await here.overview.robots(latest_day(today))
    compared = await here.comparisons.of(robot.robot for robot in measured)
    robots = await standing(here, measured, papers, compared, today)
    due = [robot for robot in robots if robot.reasons]
    told = await here.told.newest(latest_day(today))
    changed = await since_a_week(here, papers, measured, today)
    lately = await here.overview.lately(changed.since, _NEXT)
    return visit.page(
        "plant/plant.html",
        outcome=plant_outcome((cell.name for cell in here.collector.cells), measured, told),
        due=[due_robot(robot, places) for robot in due[:_NEXT]],
        due_total=len(due),
        rule=here.due,
        states=_counted(robots),
        total=len(robots),
        compared=[(one, await here.overview.campaigns_above(one.robot, one.newest)) for one in compared],
        ending=_ending(papers, today),
        since=changed.since.isoformat(),
        changed=_changed(changed.robots[:_NEXT], measured, places),
        changed_total=len(changed.robots),
        ended=changed.ended,
        lately=lately,
        moment=moment,
        newest=result_links(lately.newest, places),
        cells=cell_links(here, await here.visits.newest()),
    )


def _ending(papers: Iterable[CertificateRecord], today: date) -> list[tuple[CertificateRecord, Standing]]:
    each = [(stated, stated.standing(today)) for stated in papers]
    return [one for one in each if one[1] in {"expired", "ends soon"}]


def _changed(
    robots: Iterable[RobotChanged], measured: Iterable[RobotMeasured], places: Places
) -> list[ChangedRobot]:
    known = {robot.serial_number: robot for robot in measured}
    return [
        ChangedRobot(
            known[robot.serial_number], [(change, places.of(change.record)) for change in robot.changes]
        )
        for robot in robots
        if robot.serial_number in known  # not one that came in meanwhile
    ]


def _counted(robots: Iterable[RobotStatus]) -> list[tuple[str, str, int]]:
    """Return look, words and number of each state that some robot is in, by its first reason."""
    counts = Counter(str(robot.reasons[0].why) if robot.reasons else _CURRENT for robot in robots)
    return [(*shown, counts[state]) for state, shown in _STATES.items() if counts[state]]


_VISITS: Final = 50
_OUTCOMES: Final[Mapping[Outcome, str]] = {
    Outcome.WHOLE: "plant.cell.whole",
    Outcome.UNREACHABLE: "plant.cell.unreachable",
    Outcome.REFUSED: "plant.cell.refused",
    Outcome.ANOTHER_CHAIN: "plant.cell.another_chain",
}


@dataclass(frozen=True, slots=True)
class OtherChain:
    """What would be done with another chain that a cell shows."""

    common: int  # the last link that both have
    collected: int  # links that the plant has
    there: int  # links that the cell has now

    @property
    def in_plant_alone(self) -> int:
        """How many links the plant has that the cell has no longer."""
        return self.collected - self.common

    @property
    def to_collect(self) -> int:
        """How many links the cell has that the plant has not."""
        return self.there - self.common


@router.get("/cells/{name:path}", response_class=HTMLResponse)
async def plant_cell_page(visit: Visited, here: PlantHere, name: Name) -> HTMLResponse:
    """Show what visits to a cell found, and let a metrologist accept another chain that it shows."""
    newest = await here.visits.newest()
    if name not in newest:
        return visit.page("plant/missing.html", HTTPStatus.NOT_FOUND, sentence="plant.cell.missing", of=name)
    (cell,) = cell_links(here, {name: newest[name]})
    return visit.page(
        "plant/cell.html",
        cell=cell,
        other=None if cell.newest is None else await _other_chain(here, name, cell.newest.visit),
        branches=await here.journal.accepted_branches(name),
        visits=await here.visits.of(name, _VISITS),
        outcomes=_OUTCOMES,
        moment=moment,
    )


async def _other_chain(here: PlantContext, name: str, seen: Visit) -> OtherChain | None:
    """Return the chain that waits to be accepted; None: there is none, or it was accepted since the visit."""
    if seen.outcome is not Outcome.ANOTHER_CHAIN or seen.fork is None or not here.collector.knows(name):
        return None
    known = await here.journal.collected(await here.journal.reached(name))
    if seen.head != known.head.text:
        return None
    return OtherChain(seen.fork, known.position, seen.newest or 0)
