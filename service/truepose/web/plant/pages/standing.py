"""How robots stand, and what speaks for measuring one: each reason with the page of what gives it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import date
from urllib.parse import quote

from truepose.plant.due import Evidence, Reason, StandingRobot, Why, latest_day, standing_robots
from truepose.storage.files.foreseen import Compared
from truepose.storage.plant.certificates import StatedPaper
from truepose.storage.plant.looking_over import RobotMeasured
from truepose.web.plant.context import PlantContext
from truepose.web.plant.pages.shown import Places


@dataclass(frozen=True, slots=True)
class DueRobot:
    """A robot, and each reason to measure it with the page of what gives it."""

    of: RobotMeasured
    reasons: Sequence[tuple[Reason, str]]


async def standing(
    here: PlantContext,
    robots: Iterable[RobotMeasured],
    papers: Iterable[StatedPaper],
    compared: Sequence[Compared],
    today: date,
) -> list[StandingRobot]:
    """Return how robots stand on a day, those first that are to be measured first."""
    expires = {stated.paper.serial_number: stated.paper.expires for stated in papers}
    evidence = Evidence(await here.told.newest(latest_day(today)), expires, compared)
    return standing_robots(robots, evidence, here.due, today)


def due_robot(robot: StandingRobot, places: Places) -> DueRobot:
    """Return a robot with where each of its reasons leads."""
    measured_with = robot.measured.instrument_serial_number
    return DueRobot(robot.measured, [(one, _leads_to(one, places, measured_with)) for one in robot.reasons])


def _leads_to(reason: Reason, places: Places, measured_with: str) -> str:
    """Return the page of what gives a reason; empty: there is none."""
    if reason.compared is not None:
        return f"/fleet?type={quote(reason.compared.robot)}"
    if reason.why is Why.UNCERTIFIED:
        return f"/instruments/{quote(measured_with)}"
    return "" if reason.record is None else places.of(reason.record)
