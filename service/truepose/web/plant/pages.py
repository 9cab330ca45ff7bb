"""Pages of a plant for who keeps its robots: the plant at a glance, a robot's life, an instrument's life."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from http import HTTPStatus
from itertools import groupby
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.plant.due import DUE_AFTER_DAYS, Standing, standing_robots
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.looking import DayMeasured, ResultKind, ResultSeen
from truepose.storage.plant.records import VisitRecord
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.seen import Serial
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visit, Visited

router = APIRouter(include_in_schema=False)
_WEEK: Final = timedelta(days=7)
_NEXT: Final = 20  # robots to be measured, and what came in: what is read at a glance
_PAGES: Final = {
    "campaign": "campaigns",
    "identification": "identifications",
    "diagnosis": "diagnoses",
    "validation": "validations",
    "model": "models",
    "correction": "corrections",
}


_TITLES: Final[Mapping[ResultKind, str]] = {
    "campaign": "work.campaign",
    "identification": "work.identification",
    "diagnosis": "work.diagnosis",
    "validation": "work.validation",
    "model": "work.model",
    "correction": "work.correction",
    "report": "plant.report",
    "closing": "plant.closing",
}


@dataclass(frozen=True, slots=True)
class ShownResult:
    """A result, and where the cell shows it."""

    seen: ResultSeen
    title: str  # a key of the catalogue
    href: str  # empty: the cell has no page of it, or is none of the plant's any more


@dataclass(frozen=True, slots=True)
class ShownCell:
    """A cell, and the newest visit to it."""

    name: str
    url: str  # empty: it stands in the cells file no more
    newest: VisitRecord | None


@dataclass(frozen=True, slots=True)
class Share:
    """How much of an instrument's work was one robot."""

    robot_serial_number: str
    readings: int
    days: int
    first: str
    last: str


@router.get("/", response_class=HTMLResponse)
async def plant_page(visit: Visited, here: PlantHere) -> HTMLResponse:
    """Show who is to be measured next and why, how robots stand, what came in, and the cells."""
    now = datetime.now(UTC)
    robots = standing_robots(await here.overview.robots(), now.date())
    due = [robot for robot in robots if robot.standing is not Standing.CURRENT]
    lately = await here.overview.lately(now - _WEEK, _NEXT)
    return visit.page(
        "plant/plant.html",
        due=due[:_NEXT],
        due_total=len(due),
        limit=DUE_AFTER_DAYS,
        states=Counter(robot.standing.value for robot in robots),
        total=len(robots),
        lately=lately,
        moment=moment,
        newest=await _shown(here, lately.newest),
        cells=_cells(here, await here.visits.newest()),
    )


@router.get("/robots/{serial}", response_class=HTMLResponse)
async def robot_life_page(visit: Visited, here: PlantHere, serial: Serial) -> HTMLResponse:
    """Show what was measured and made of a robot, newest day first."""
    try:
        robot = await here.looks.robot(serial)
    except NotInPlantError:
        return _missing(visit, serial)
    results = await _shown(here, await here.looks.life_of_robot(serial))
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
    return visit.page("plant/instrument.html", instrument=instrument, shares=_shares(days), days=days[::-1])


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


def _cells(here: PlantContext, visits: Mapping[str, VisitRecord | None]) -> list[ShownCell]:
    urls = _urls(here)
    return [ShownCell(name, urls.get(name, ""), newest) for name, newest in visits.items()]


async def _shown(here: PlantContext, results: Iterable[ResultSeen]) -> list[ShownResult]:
    urls, branches = _urls(here), await here.overview.newest_branches()
    return [ShownResult(seen, _TITLES[seen.kind], _href(seen, urls, branches)) for seen in results]


def _href(seen: ResultSeen, urls: Mapping[str, str], branches: Mapping[str, int]) -> str:
    """Return where a cell shows a result; on another chain its number may be that of another record."""
    known = seen.cell in urls and branches.get(seen.cell) == seen.branch_id
    return f"{urls[seen.cell]}/{_PAGES[seen.kind]}/{seen.record_id}" if known and seen.kind in _PAGES else ""


def _urls(here: PlantContext) -> dict[str, str]:
    return {cell.name: cell.url for cell in here.collector.cells}
