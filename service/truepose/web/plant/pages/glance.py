"""The plant at a glance: who is to be measured next and why, what ends, what changed, and the cells."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.cell.certificates import Standing
from truepose.plant.changes import Changed, RobotChanged
from truepose.plant.due import StandingRobot, Why, latest_day
from truepose.storage.plant.certificates import StatedPaper
from truepose.storage.plant.looking_over import RobotMeasured
from truepose.web.plant.changes import since_a_week
from truepose.web.plant.context import PlantHere
from truepose.web.plant.pages.shown import Places, places_of, shown_cells, shown_results
from truepose.web.plant.pages.standing import due_robot, standing
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(include_in_schema=False)
_NEXT: Final = 20  # robots to be measured, and that changed, and what came in: what is read at a glance
_CURRENT: Final = "current"
_STATES: Final[Mapping[str, tuple[str, str]]] = {  # how a badge looks, and what it says
    _CURRENT: ("good", "plant.state.current"),
    Why.UNMEASURED: ("warn", "plant.state.unmeasured"),
    Why.DOUBTFUL: ("warn", "plant.state.doubtful"),
    Why.FAILED: ("bad", "plant.state.failed"),
    Why.UNCERTIFIED: ("bad", "plant.state.uncertified"),
    Why.CHANGED: ("warn", "plant.state.changed"),
    Why.UNEXPLAINED: ("warn", "plant.state.unexplained"),
    Why.WORSENING: ("warn", "plant.state.worsening"),
    Why.OVERDUE: ("warn", "plant.state.overdue"),
    Why.ASKED: ("warn", "plant.state.asked"),
}


@dataclass(frozen=True, slots=True)
class ChangedRobot:
    """A robot of which something changed, and each change with the page of the record that says so."""

    of: RobotMeasured
    changes: Sequence[tuple[Changed, str]]


@router.get("/", response_class=HTMLResponse)
async def plant_page(visit: Visited, here: PlantHere) -> HTMLResponse:
    """Show who is to be measured next and why, how robots stand, what changed, and the cells."""
    today = datetime.now(UTC).date()
    papers, places = await here.certificates.that_count(), await places_of(here)
    measured = await here.overview.robots(latest_day(today))
    compared = await here.comparisons.of(robot.robot for robot in measured)
    robots = await standing(here, measured, papers, compared, today)
    due = [robot for robot in robots if robot.reasons]
    changed = await since_a_week(here, papers, measured, today)
    lately = await here.overview.lately(changed.since, _NEXT)
    return visit.page(
        "plant/plant.html",
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
        newest=shown_results(lately.newest, places),
        cells=shown_cells(here, await here.visits.newest()),
    )


def _ending(papers: Iterable[StatedPaper], today: date) -> list[tuple[StatedPaper, Standing]]:
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


def _counted(robots: Iterable[StandingRobot]) -> list[tuple[str, str, int]]:
    """Return look, words and number of each state that some robot is in, by its first reason."""
    counts = Counter(str(robot.reasons[0].why) if robot.reasons else _CURRENT for robot in robots)
    return [(*shown, counts[state]) for state, shown in _STATES.items() if counts[state]]
