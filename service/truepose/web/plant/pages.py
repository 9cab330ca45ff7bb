"""Pages of a plant for who keeps its robots: a robot's life, an instrument's life."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from itertools import groupby

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.looking import DayMeasured
from truepose.web.plant.context import PlantHere
from truepose.web.plant.seen import Serial
from truepose.web.plant.shown import places_of, shown_results
from truepose.web.visiting.visits import Visit, Visited

router = APIRouter(include_in_schema=False)


@dataclass(frozen=True, slots=True)
class Share:
    """How much of an instrument's work was one robot."""

    robot_serial_number: str
    readings: int
    days: int
    first: str
    last: str


@router.get("/robots/{serial}", response_class=HTMLResponse)
async def robot_life_page(visit: Visited, here: PlantHere, serial: Serial) -> HTMLResponse:
    """Show what was measured and made of a robot, newest day first."""
    try:
        robot = await here.looks.robot(serial)
    except NotInPlantError:
        return _missing(visit, serial)
    results = shown_results(await here.looks.life_of_robot(serial), await places_of(here))
    days = await here.looks.days_of_robot(serial)
    return visit.page("plant/robot.html", robot=robot, results=results, days=days[::-1])


@router.get("/instruments/{serial}", response_class=HTMLResponse)
async def instrument_life_page(visit: Visited, here: PlantHere, serial: Serial) -> HTMLResponse:
    """Show which robots an instrument measured, and on which days."""
    try:
        instrument = await here.looks.instrument(serial)
    except NotInPlantError:
        return _missing(visit, serial)
    days = await here.looks.days_of_instrument(serial)
    today, stated = datetime.now(UTC).date(), await here.certificates.of_instrument(serial)
    return visit.page(
        "plant/instrument.html",
        instrument=instrument,
        shares=_shares(days),
        certificates=[(one, one.standing(today)) for one in stated],
        days=days[::-1],
    )


def _missing(visit: Visit, serial: str) -> HTMLResponse:
    return visit.page("plant/missing.html", HTTPStatus.NOT_FOUND, serial=serial)


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
