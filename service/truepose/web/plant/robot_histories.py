"""Pages of a robot's life and of an instrument's life."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from itertools import groupby
from typing import Final, TypeVar

from fastapi import APIRouter
from fastapi.responses import HTMLResponse
from markupsafe import Markup

from truepose.plant.calibration_due import latest_day
from truepose.plant.outcome import robot_outcome
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.queries import DayMeasured, ResultRecord
from truepose.web.pages.rendering import Visit, Visited, Whole, render_part
from truepose.web.plant.context import PlantHere
from truepose.web.plant.figures import CoursesDrawing, draw_courses
from truepose.web.plant.inventory import Serial
from truepose.web.plant.links import due_robot, places_of, result_links, standing

_OVER_DAYS: Final = ("identification", "diagnosis")
_AT_ONCE_S: Final = 0.03  # that pictures may hold up a life: those that are kept are there by then

router = APIRouter(include_in_schema=False)
Dated = TypeVar("Dated", DayMeasured, ResultRecord)


@dataclass(frozen=True, slots=True)
class TrendFigures:
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
    today = datetime.now(UTC).date()
    upto = latest_day(today).isoformat()
    found = await here.overview.robot(serial, latest_day(today))
    if not found:
        return _missing(visit, serial)
    compared, places = await here.comparisons.of([found[0].robot]), await places_of(here)
    (robot,) = await standing(here, found, await here.certificates.that_count(), compared, today)
    told = await here.told.newest(latest_day(today))
    results = await here.looks.life_of_robot(serial)
    return visit.page(
        "plant/robot.html",
        robot=found[0],
        outcome=robot_outcome(told.get(serial, {})),
        due=due_robot(robot, places),
        results=result_links(_to_come_last(results, upto), places),
        days=_to_come_last((await here.looks.days_of_robot(serial))[::-1], upto),
        upto=upto,
        courses=await _courses(visit, here, serial, upto, whole=whole),
    )


async def _courses(visit: Visit, here: PlantHere, serial: str, upto: str, *, whole: bool) -> TrendFigures:
    """Return the courses of a robot's error and causes, drawn as soon as there is something over days.

    A day that is yet to come would make one line of all others.
    """
    every = await here.told.of_robot(serial)
    told = tuple(one for one in every if one.kind in _OVER_DAYS and one.measured_on <= upto)
    if not told:
        return TrendFigures(None, is_there=False)
    asked = CoursesDrawing(told, visit.words.tag)
    of = f"courses {serial} {len(told)} {max(one.id for one in told)}"
    drawn = await render_part(
        visit, of, lambda: here.drawing_desk.draw(draw_courses, asked), whole=whole, at_once_s=_AT_ONCE_S
    )
    return TrendFigures(drawn, is_there=True)


@router.get("/instruments/{serial:path}", response_class=HTMLResponse)
async def instrument_life_page(visit: Visited, here: PlantHere, serial: Serial) -> HTMLResponse:
    """Show which robots an instrument measured, and on which days."""
    today = datetime.now(UTC).date()
    try:
        instrument = await here.looks.instrument(serial, latest_day(today))
    except NotInPlantError:
        return _missing(visit, serial)
    upto = latest_day(today).isoformat()
    days = await here.looks.days_of_instrument(serial)
    stated = await here.certificates.of_instrument(serial)
    return visit.page(
        "plant/instrument.html",
        instrument=instrument,
        shares=_shares(days, upto),
        certificates=[(one, one.standing(today)) for one in stated],
        days=_to_come_last(days[::-1], upto),
        upto=upto,
    )


def _missing(visit: Visit, serial: str) -> HTMLResponse:
    return visit.page("plant/missing.html", HTTPStatus.NOT_FOUND, sentence="plant.missing", of=serial)


def _to_come_last(measured: Iterable[Dated], upto: str) -> list[Dated]:
    """Return results or days in their order, behind them those that are dated later than can be."""
    return sorted(measured, key=lambda one: one.measured_on > upto)


def _shares(days: Iterable[DayMeasured], upto: str) -> list[Share]:
    """Return the robots of some days, the one that was measured last first; of days to come, none."""
    past = (day for day in days if day.measured_on <= upto)
    by_robot = sorted(past, key=lambda day: (day.robot_serial_number, day.measured_on))
    shares = [
        _share(serial, [*of_robot])
        for serial, of_robot in groupby(by_robot, lambda day: day.robot_serial_number)
    ]
    return sorted(shares, key=lambda share: share.last, reverse=True)


def _share(serial: str, days: list[DayMeasured]) -> Share:
    readings = sum(day.readings for day in days)
    measured_on = [day.measured_on for day in days]
    return Share(serial, readings, len({*measured_on}), measured_on[0], measured_on[-1])
