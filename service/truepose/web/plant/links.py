"""Results, cells and due robots as pages of a plant show them, each with the page that gives it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final
from urllib.parse import quote

from truepose.plant.calibration_due import (
    DueReason,
    Evidence,
    Reason,
    RobotStatus,
    latest_day,
    standing_robots,
)
from truepose.storage.caches import FleetComparison
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.overview import ResultFacts, RobotMeasured
from truepose.storage.plant.queries import ResultRecord
from truepose.storage.plant.records import VisitRecord
from truepose.storage.results.items import WorkKind
from truepose.web.pages.records import address_of
from truepose.web.plant.context import PlantContext

_TITLES: Final = {"report": "plant.report", "closing": "plant.closing"}  # of what no cell has a page of


@dataclass(frozen=True, slots=True)
class ResultLink:
    """A result, and where the cell shows it."""

    seen: ResultRecord
    title: str  # a key of the catalogue
    href: str  # empty: the cell has no page of it, or is none of the plant's any more


@dataclass(frozen=True, slots=True)
class CellLink:
    """A cell, and the newest visit to it."""

    name: str
    url: str  # empty: it stands in the cells file no more
    newest: VisitRecord | None


@dataclass(frozen=True, slots=True)
class Places:
    """Where the cells of a plant show what they have."""

    urls: Mapping[str, str]  # by cell
    branches: Mapping[str, int]  # that a cell's own numbers are those of

    def of(self, seen: ResultRecord | ResultFacts) -> str:
        """Return where a cell shows a result; on another chain its number may be that of another record."""
        known = seen.cell in self.urls and self.branches.get(seen.cell) == seen.branch_id
        if not known or seen.kind in _TITLES:
            return ""
        return self.urls[seen.cell] + address_of(WorkKind(seen.kind), seen.record_id)


async def places_of(here: PlantContext) -> Places:
    """Return where the cells show what they have, as it is now."""
    return Places(_urls(here), await here.overview.newest_branches())


def result_links(results: Iterable[ResultRecord], places: Places) -> list[ResultLink]:
    """Return results with their titles and places."""
    return [
        ResultLink(seen, _TITLES.get(seen.kind, f"work.{seen.kind}"), places.of(seen)) for seen in results
    ]


def cell_links(here: PlantContext, visits: Mapping[str, VisitRecord | None]) -> list[CellLink]:
    """Return every cell with its newest visit."""
    urls = _urls(here)
    return [CellLink(name, urls.get(name, ""), newest) for name, newest in visits.items()]


def _urls(here: PlantContext) -> dict[str, str]:
    return {cell.name: cell.url for cell in here.collector.cells}


@dataclass(frozen=True, slots=True)
class DueRobot:
    """A robot, and each reason to measure it with the page of what gives it."""

    of: RobotMeasured
    reasons: Sequence[tuple[Reason, str]]


async def standing(
    here: PlantContext,
    robots: Iterable[RobotMeasured],
    papers: Iterable[CertificateRecord],
    compared: Sequence[FleetComparison],
    today: date,
) -> list[RobotStatus]:
    """Return how robots stand on a day, those first that are to be measured first."""
    expires = {stated.paper.serial_number: stated.paper.expires for stated in papers}
    evidence = Evidence(await here.told.newest(latest_day(today)), expires, compared)
    return standing_robots(robots, evidence, here.due, today)


def due_robot(robot: RobotStatus, places: Places) -> DueRobot:
    """Return a robot with where each of its reasons leads."""
    measured_with = robot.measured.instrument_serial_number
    return DueRobot(robot.measured, [(one, _leads_to(one, places, measured_with)) for one in robot.reasons])


def _leads_to(reason: Reason, places: Places, measured_with: str) -> str:
    """Return the page of what gives a reason; empty: there is none."""
    if reason.compared is not None:
        return f"/fleet?type={quote(reason.compared.robot)}"
    if reason.why is DueReason.UNCERTIFIED:
        return f"/instruments/{quote(measured_with)}"
    return "" if reason.record is None else places.of(reason.record)
