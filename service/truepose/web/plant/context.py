"""What the routes of a plant work with; made once by the composition root."""

import asyncio
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request

from truepose.analysis.drawing import DrawingDesk
from truepose.analysis.fleets.desk import FleetDesk
from truepose.operation.people.desk import PeopleDesk
from truepose.plant.changes import RobotsChanged
from truepose.plant.collector import Collector
from truepose.plant.due import DueAfter
from truepose.storage.backup.schedule import BackupSchedule
from truepose.storage.database import Database
from truepose.storage.files.foreseen import Comparisons
from truepose.storage.plant.certificates import PlantCertificates
from truepose.storage.plant.hand_downs import HandDownRepository
from truepose.storage.plant.journal import JournalRepository
from truepose.storage.plant.lines import JournalLines
from truepose.storage.plant.looking import PlantLooks
from truepose.storage.plant.looking_over import PlantOverview
from truepose.storage.plant.newest import PlantTold
from truepose.storage.plant.visits import VisitRepository


@dataclass(frozen=True, slots=True)
class Place:
    """What stands at the head of every page."""

    name: str


@dataclass(frozen=True, slots=True)
class PlantContext:
    """Everything behind the routes of a plant."""

    version: str
    cell: Place  # pages of people are those of a cell, and name what they are of
    database: Database
    people: PeopleDesk
    journal: JournalRepository
    visits: VisitRepository
    hand_downs: HandDownRepository
    lines: JournalLines
    looks: PlantLooks
    overview: PlantOverview
    told: PlantTold
    changed: RobotsChanged
    certificates: PlantCertificates
    due: DueAfter
    fleets: FleetDesk
    comparisons: Comparisons
    drawing_desk: DrawingDesk
    collector: Collector
    copies: BackupSchedule | None  # None: none are wanted
    stopping: asyncio.Event  # set when the service ends
    simulated: bool = False
    places: tuple[tuple[str, str, str], ...] = (("cell", "/", "plant"),)  # icon, path, word: a plant has one


async def _context(request: Request) -> PlantContext:
    return cast(PlantContext, request.app.state.context)


PlantHere = Annotated[PlantContext, Depends(_context)]
