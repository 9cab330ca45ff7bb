"""Joins a plant: opens its database, its people and its collector, and closes them in reverse order."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Callable
from datetime import UTC, datetime

from truepose.analysis.fleets.campaign_summaries import CampaignSummaryService
from truepose.analysis.job_queue.supervisor import perform_in_worker
from truepose.analysis.page_services import RenderCache, Renderer
from truepose.app.server import ServiceDefinition, run
from truepose.app.startup import beside, copies_of, opened_database, people_of, program_version
from truepose.exchange.cells.plant import read_plant_file
from truepose.plant.calibration_due import DueAfter
from truepose.plant.changes import RobotsChanged
from truepose.plant.collector import Collector, Pace, PlantRepositories, collecting
from truepose.settings import PlantSettings
from truepose.storage.caches import Comparisons, DrawnFolder
from truepose.storage.contents import require_of_plant
from truepose.storage.integrity.monitor import Guard
from truepose.storage.plant.cells import VisitRepository
from truepose.storage.plant.certificates import PlantCertificates
from truepose.storage.plant.deployments import HandDownRepository
from truepose.storage.plant.journal import JournalLines, JournalRepository
from truepose.storage.plant.overview import CollectedCampaigns, PlantOverview, PlantResults
from truepose.storage.plant.queries import PlantQueries
from truepose.web.plant.application import create_plant_application
from truepose.web.plant.changes import read_ahead
from truepose.web.plant.context import Place, PlantContext


def serve_plant(settings: PlantSettings) -> int:
    """Serve a plant until interrupted and return the exit status, as `serve` does a cell."""

    def opened(_lines_lost: Callable[[], int]) -> contextlib.AbstractAsyncContextManager[PlantContext]:
        return open_plant(settings)

    return run(settings.service, ServiceDefinition(opened, create_plant_application))


@contextlib.asynccontextmanager
async def open_plant(settings: PlantSettings) -> AsyncIterator[PlantContext]:
    """Open the storage of a plant and visit its cells as long as the context lasts.

    Raises
    ------
    StorageError
        The database cannot be used, or another service has it.
    InputFileError
        The cells file is wrong.
    """
    plant = read_plant_file(settings.cells_file)
    async with contextlib.AsyncExitStack() as stack:
        database = await asyncio.to_thread(opened_database, settings.service.database_url)
        stack.callback(database.close)
        await require_of_plant(database)
        people = await stack.enter_async_context(people_of(database, settings.service))
        journal, visits = JournalRepository(database), VisitRepository(database)
        hand_downs = HandDownRepository(database)
        collector = Collector(
            plant.cells, PlantRepositories(journal, hand_downs), visits, Pace(settings.every_s)
        )
        await journal.enter(*(cell.name for cell in plant.cells))
        beside(stack, Guard(database).follow, "storage guard")
        copies = copies_of(settings.service, stack)
        await stack.enter_async_context(collecting(collector))
        told = PlantResults(database)
        await read_ahead(told, datetime.now(UTC).date())  # of all robots: no page waits for it
        drawing = Renderer(perform_in_worker, RenderCache(DrawnFolder.beside(database.file)))
        stack.push_async_callback(drawing.kept.close)
        # Who waits for workers elsewhere keeps no report from being drawn.
        asking = drawing if settings.workers is None else Renderer(perform_in_worker, drawing.kept)
        telling = CampaignSummaryService.folder(database.file), asking, settings.workers
        yield PlantContext(
            version=program_version(),
            cell=Place(settings.name),
            database=database,
            people=people,
            journal=journal,
            visits=visits,
            hand_downs=hand_downs,
            lines=JournalLines(database),
            looks=PlantQueries(database),
            overview=PlantOverview(database),
            told=told,
            changed=RobotsChanged(),
            certificates=PlantCertificates(database),
            fleets=CampaignSummaryService(CollectedCampaigns(database), *telling),
            comparisons=Comparisons(database.file),
            drawing_desk=drawing,
            due=DueAfter(settings.due_after_days, plant.due_after_days),
            collector=collector,
            copies=copies,
            stopping=asyncio.Event(),
        )
