"""What the routes of a plant work with; made once by the composition root."""

import asyncio
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request

from truepose.analysis.fleets.campaign_summaries import CampaignSummaryService
from truepose.analysis.page_services import Renderer
from truepose.people.accounts import PeopleService
from truepose.plant.calibration_due import DueAfter
from truepose.plant.changes import RobotsChanged
from truepose.plant.collector import Collector
from truepose.storage.backup.schedule import BackupSchedule
from truepose.storage.caches import Comparisons
from truepose.storage.database import Database
from truepose.storage.plant.cells import VisitRepository
from truepose.storage.plant.certificates import PlantCertificates
from truepose.storage.plant.deployments import HandDownRepository
from truepose.storage.plant.journal import JournalLines, JournalRepository
from truepose.storage.plant.overview import PlantOverview, PlantResults
from truepose.storage.plant.queries import PlantQueries


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
    people: PeopleService
    journal: JournalRepository
    visits: VisitRepository
    hand_downs: HandDownRepository
    lines: JournalLines
    looks: PlantQueries
    overview: PlantOverview
    told: PlantResults
    changed: RobotsChanged
    certificates: PlantCertificates
    due: DueAfter
    fleets: CampaignSummaryService
    comparisons: Comparisons
    drawing_desk: Renderer
    collector: Collector
    copies: BackupSchedule | None  # None: none are wanted
    stopping: asyncio.Event  # set when the service ends
    simulated: bool = False
    places: tuple[tuple[str, str, str], ...] = (("cell", "/", "plant"),)  # icon, path, word: a plant has one


async def _context(request: Request) -> PlantContext:
    return cast(PlantContext, request.app.state.context)


PlantHere = Annotated[PlantContext, Depends(_context)]
