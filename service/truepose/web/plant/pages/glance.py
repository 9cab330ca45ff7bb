"""The plant at a glance: who is to be measured next and why, what ends, what came in, and the cells."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.domain.cell.certificates import Standing
from truepose.plant.due import Evidence, Reason, StandingRobot, Why, latest_day, standing_robots
from truepose.storage.plant.certificates import StatedPaper
from truepose.storage.plant.looking_over import RobotMeasured
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.pages.shown import Places, places_of, shown_cells, shown_results
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(include_in_schema=False)
_WEEK: Final = timedelta(days=7)
_NEXT: Final = 20  # robots to be measured, and what came in: what is read at a glance
_CURRENT: Final = "current"
_STATES: Final[Mapping[str, tuple[str, str]]] = {  # how a badge looks, and what it says
    _CURRENT: ("good", "plant.state.current"),
    Why.UNMEASURED: ("warn", "plant.state.unmeasured"),
    Why.DOUBTFUL: ("warn", "plant.state.doubtful"),
    Why.FAILED: ("bad", "plant.state.failed"),
    Why.UNCERTIFIED: ("bad", "plant.state.uncertified"),
    Why.CHANGED: ("warn", "plant.state.changed"),
    Why.UNEXPLAINED: ("warn", "plant.state.unexplained"),
    Why.OVERDUE: ("warn", "plant.state.overdue"),
    Why.ASKED: ("warn", "plant.state.asked"),
}


@dataclass(frozen=True, slots=True)
class DueRobot:
    """A robot that is to be measured, and each reason with the page of the record that gives it."""

    of: RobotMeasured
    reasons: Sequence[tuple[Reason, str]]


@router.get("/", response_class=HTMLResponse)
async def plant_page(visit: Visited, here: PlantHere) -> HTMLResponse:
    """Show who is to be measured next and why, how robots stand, what came in, and the cells."""
    now = datetime.now(UTC)
    papers, places = await here.certificates.that_count(), await places_of(here)
    robots = await _standing(here, papers, now.date())
    due = [robot for robot in robots if robot.reasons]
    lately = await here.overview.lately(now - _WEEK, _NEXT)
    return visit.page(
        "plant/plant.html",
        due=[_due(robot, places) for robot in due[:_NEXT]],
        due_total=len(due),
        rule=here.due,
        states=_counted(robots),
        total=len(robots),
        ending=_ending(papers, now.date()),
        lately=lately,
        moment=moment,
        newest=shown_results(lately.newest, places),
        cells=shown_cells(here, await here.visits.newest()),
    )


async def _standing(here: PlantContext, papers: Iterable[StatedPaper], today: date) -> list[StandingRobot]:
    expires = {stated.paper.serial_number: stated.paper.expires for stated in papers}
    upto = latest_day(today)
    evidence = Evidence(await here.told.newest(upto), expires)
    return standing_robots(await here.overview.robots(upto), evidence, here.due, today)


def _ending(papers: Iterable[StatedPaper], today: date) -> list[tuple[StatedPaper, Standing]]:
    standing = [(stated, stated.standing(today)) for stated in papers]
    return [one for one in standing if one[1] in {"expired", "ends soon"}]


def _due(robot: StandingRobot, places: Places) -> DueRobot:
    reasons = [
        (reason, "" if reason.record is None else places.of(reason.record)) for reason in robot.reasons
    ]
    return DueRobot(robot.measured, reasons)


def _counted(robots: Iterable[StandingRobot]) -> list[tuple[str, str, int]]:
    """Return look, words and number of each state that some robot is in, by its first reason."""
    counts = Counter(str(robot.reasons[0].why) if robot.reasons else _CURRENT for robot in robots)
    return [(*shown, counts[state]) for state, shown in _STATES.items() if counts[state]]
