"""Which robots are to be measured next, and why: by the days since each was measured last.

First those of which nobody knows how they stand, then the longest ago; equal ones by serial number. The
clock of a cell may be wrong: a robot whose last day has not come yet would otherwise never be due.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from typing import Final

from truepose.storage.plant.looking_over import RobotMeasured

DUE_AFTER_DAYS: Final = 30  # a quick check each month
_AHEAD_DAYS: Final = 1  # of the plant's day, in another time zone


class Standing(StrEnum):
    """How a robot stands, the most urgent first."""

    UNMEASURED = "unmeasured"
    DOUBTFUL = "doubtful"  # its last day is not over yet, or is no day
    OVERDUE = "overdue"
    CURRENT = "current"


@dataclass(frozen=True, slots=True)
class StandingRobot:
    """A robot, how it stands, and for how long."""

    measured: RobotMeasured
    standing: Standing
    days: int  # since it was measured last; 0 where that is not known


def standing_robots(robots: Iterable[RobotMeasured], today: date) -> list[StandingRobot]:
    """Return how robots stand on a day, those first that are to be measured first."""
    return sorted((_standing(robot, today) for robot in robots), key=_urgency)


def _standing(robot: RobotMeasured, today: date) -> StandingRobot:
    if not robot.last_measured_on:
        return StandingRobot(robot, Standing.UNMEASURED, 0)
    days = _days_between(robot.last_measured_on, today)
    if days is None or days < -_AHEAD_DAYS:
        return StandingRobot(robot, Standing.DOUBTFUL, 0)
    return StandingRobot(robot, Standing.OVERDUE if days > DUE_AFTER_DAYS else Standing.CURRENT, max(days, 0))


def _days_between(day: str, today: date) -> int | None:
    try:
        return (today - date.fromisoformat(day)).days
    except ValueError:
        return None


def _urgency(robot: StandingRobot) -> tuple[int, int, str]:
    return [*Standing].index(robot.standing), -robot.days, robot.measured.serial_number
