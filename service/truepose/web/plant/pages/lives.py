"""A robot's life, an instrument's life."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from itertools import groupby
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.plant.due import latest_day
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.looking import DayMeasured
from truepose.web.plant.context import PlantHere
from truepose.web.plant.pages.life_drawn import CoursesAsked, drawn_courses
from truepose.web.plant.pages.shown import places_of, shown_results
from truepose.web.plant.seen import Serial
from truepose.web.visiting.drawn import Whole, drawn_part
from truepose.web.visiting.visits import Visit, Visited

_OVER_DAYS: Final = ("identification", "diagnosis")
_AT_ONCE_S: Final = 0.03  # that pictures may hold up a life: those that are kept are there by then

router = APIRouter(include_in_schema=False)


@dataclass(frozen=True, slots=True)
class Courses:
    """Pictures over days; None: they are being drawn, or there are none."""

    drawn: Markup | None
    is_there: bool


@dataclass(frozen=True, slots=True)
class Share:
    """How much of an instrument's work was one robot."""

    robot_serial_number: str
    readings: int
    days: int
    first: str
    last: str


@router.get("/robots/{serial:path}", response_class=HTMLResponse)
async def robot_life_page(
    visit: Visited, here: PlantHere, serial: Serial, whole: Whole = False
) -> HTMLResponse:
    """Show what was measured and made of a robot, newest day first, and how its error and its causes went."""
    try:
        robot = await here.looks.robot(serial, latest_day(datetime.now(UTC).date()))
    except NotInPlantError:
        return _missing(visit, serial)
    results = shown_results(await here.looks.life_of_robot(serial), await places_of(here))
    days = await here.looks.days_of_robot(serial)
    courses = await _courses(visit, here, serial, whole=whole)
    return visit.page("plant/robot.html", robot=robot, results=results, days=days[::-1], courses=courses)


async def _courses(visit: Visit, here: PlantHere, serial: str, *, whole: bool) -> Courses:
    """Return the courses of a robot's error and causes, drawn as soon as there is something over days."""
    told = tuple(one for one in await here.told.of_robot(serial) if one.kind in _OVER_DAYS)
    if not told:
        return Courses(None, is_there=False)
    asked = CoursesAsked(told, visit.words.tag)
    of = f"courses {serial} {len(told)} {max(one.id for one in told)}"
    drawn = await drawn_part(
        visit, of, lambda: here.drawing_desk.draw(drawn_courses, asked), whole=whole, at_once_s=_AT_ONCE_S
    )
    return Courses(drawn, is_there=True)


@router.get("/instruments/{serial:path}", response_class=HTMLResponse)
async def instrument_life_page(visit: Visited, here: PlantHere, serial: Serial) -> HTMLResponse:
    """Show which robots an instrument measured, and on which days."""
    today = datetime.now(UTC).date()
    try:
        instrument = await here.looks.instrument(serial, latest_day(today))
    except NotInPlantError:
        return _missing(visit, serial)
    days = await here.looks.days_of_instrument(serial)
    stated = await here.certificates.of_instrument(serial)
    return visit.page(
        "plant/instrument.html",
        instrument=instrument,
        shares=_shares(days),
        certificates=[(one, one.standing(today)) for one in stated],
        days=days[::-1],
    )


def _missing(visit: Visit, serial: str) -> HTMLResponse:
    return visit.page("plant/missing.html", HTTPStatus.NOT_FOUND, sentence="plant.missing", of=serial)


def _shares(days: Iterable[DayMeasured]) -> list[Share]:
    """Return the robots of some days, the one that was measured last first."""
    by_robot = sorted(days, key=lambda day: (day.robot_serial_number, day.measured_on))
    shares = [
        _share(serial, [*of_robot])
        for serial, of_robot in groupby(by_robot, lambda day: day.robot_serial_number)
    ]
    return sorted(shares, key=lambda share: share.last, reverse=True)


def _share(serial: str, days: list[DayMeasured]) -> Share:
    readings = sum(day.readings for day in days)
    measured_on = [day.measured_on for day in days]
    return Share(serial, readings, len({*measured_on}), measured_on[0], measured_on[-1])
