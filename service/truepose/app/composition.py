"""Joins everything: opens what the settings name, hands it to the routes, closes it in reverse order."""

import asyncio
import contextlib
import dataclasses
import functools
import logging
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Final, cast

from truepose.analysis.campaigns.records import CampaignService
from truepose.analysis.drafts import DraftService
from truepose.analysis.job_queue.supervisor import Perform, perform_in_worker
from truepose.analysis.job_queue.uploads import Uploads
from truepose.analysis.jobs import JobService
from truepose.analysis.page_services import AccuracyService, RenderCache, Renderer
from truepose.app.errors import ScenarioRefusedError
from truepose.app.server import ServiceDefinition, run
from truepose.app.simulation import Simulation, running_simulation
from truepose.app.startup import (
    allowed_hosts,
    beside,
    copies_of,
    opened_database,
    people_of,
    program_version,
    stop_streams,
)
from truepose.domain.cell import Cell, DeviceEntry
from truepose.exchange.cells.file import read_cell, simulated_cell
from truepose.health import HealthMonitor
from truepose.messages.message import message
from truepose.people.accounts import PeopleService
from truepose.sessions.ballbar.planning import BallbarWork
from truepose.sessions.ballbar.service import BallbarSessions
from truepose.sessions.cell import CurrentCell
from truepose.sessions.closing import ClosingService
from truepose.sessions.contact.service import ContactSessions
from truepose.sessions.devices import DeviceRegistry, MountedDevice
from truepose.sessions.guide.guide import Outlooks
from truepose.sessions.guide.service import GuidedSessions
from truepose.sessions.repeated_diagnosis import RepeatedDiagnosis
from truepose.sessions.service import SessionService
from truepose.sessions.simulated import FaultService, SimulatedOperatorService
from truepose.sessions.tracker.service import TrackerSessions
from truepose.settings import Settings
from truepose.storage.caches import DrawnFolder
from truepose.storage.contents import require_of_cell
from truepose.storage.database import Database
from truepose.storage.drafts import DraftFolder
from truepose.storage.integrity.monitor import Guard
from truepose.storage.ledger.added_stops import AddedStopsRepository, ClosingRepository
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.series import SeriesRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.ledger.tracker_readings import ReadingRepository
from truepose.storage.record_insertion import EventRepository
from truepose.storage.results.campaigns import CampaignRepository
from truepose.storage.results.corrections import CorrectionRepository
from truepose.storage.results.diagnoses import DiagnosisRepository
from truepose.storage.results.jobs import JobRepository
from truepose.storage.results.lineage import Lineages, WorkList
from truepose.storage.results.models import ResultRepository
from truepose.storage.results.reports import ReportRepository
from truepose.storage.results.set_aside import SetAsideRepository
from truepose.web.application import create_application
from truepose.web.asgi import Application
from truepose.web.context import Context, Endpoint
from truepose.web.middleware.hosts import Proxies
from truepose_drivers.api import DriverPlugin, FullClock
from truepose_drivers.registry import DriverRegistry, load_registry

_LOG: Final = logging.getLogger(__name__)
_REAL_CLOCK: Final = "monotonic_clock"
_NOT_DEVICES: Final = {"clock", "truth"}  # endpoints that no session measures with
_TOOL_FILE: Final = "tool_file"  # option of a driver that brings the artefact's definition to its camera
_RESTARTED: Final = message("job.service_ended")


def create_app(
    settings: Settings, registry: DriverRegistry | None = None, perform: Perform = perform_in_worker
) -> Application:
    """Return the service as an ASGI application; its lifespan opens and closes everything it works with.

    Parameters
    ----------
    settings : Settings
    registry : DriverRegistry, optional
        Which drivers there are; by default the installed ones.
    perform : Perform
        Who does the jobs; by default a worker process each.

    Raises
    ------
    UnusableHostError
        The settings allow what is no name of a host.
    UnusableProxyError
        The settings take the word of what can be no proxy.
    """
    hosts, proxies = allowed_hosts(settings), Proxies(settings.proxies)
    opened = functools.partial(open_context, settings, registry, perform)
    return create_application(program_version(), opened, hosts, proxies)


@contextlib.asynccontextmanager
async def open_context(
    settings: Settings,
    registry: DriverRegistry | None = None,
    perform: Perform = perform_in_worker,
    lines_lost: Callable[[], int] = lambda: 0,
) -> AsyncIterator[Context]:
    """Open storage, simulated cell and drivers, and find what an earlier service left unfinished.

    `lines_lost` says how many lines of the log could not be written.

    Raises
    ------
    StorageError
        The database cannot be used, or another service has it.
    InputFileError
        The cell file is wrong.
    StartError
        The simulated cell did not come up.
    DriverError
        A device of the cell cannot be what the cell file says.
    """
    drivers = load_registry() if registry is None else registry
    async with contextlib.AsyncExitStack() as stack:
        cell = _cell(settings)
        present = _present(cell, settings)
        database = await asyncio.to_thread(opened_database, settings.database_url)
        stack.callback(database.close)
        # One mistyped command mixed the records of a plant and a cell in one chain, for good (commit
        # 65876b09).
        await require_of_cell(database)
        state = database.file.with_name(f"{database.file.name}.cell.json")
        simulation = await _simulation(cell, settings, state, stack)
        cell = _with_simulated_devices(cell, simulation, drivers)
        rack = _rack(cell, simulation, drivers)
        stack.push_async_callback(rack.clock.close)
        stack.push_async_callback(rack.close)
        backups = copies_of(settings, stack)
        lookout = HealthMonitor(database, rack, cell, backups, lines_lost)
        people = await stack.enter_async_context(people_of(database, settings))
        context = _context(cell, present, database, rack, simulation, perform, lookout, people)
        await context.session_desk.recover()
        await context.job_desk.mark_interrupted(_RESTARTED)
        # Closed from the last line up: streams, drawings, sessions, jobs; what they use, devices and
        # database, ends after them.
        stack.push_async_callback(context.job_desk.close)
        stack.push_async_callback(context.session_desk.close)
        stack.push_async_callback(context.drawing_desk.kept.close)
        stack.callback(stop_streams, context)
        beside(stack, Guard(database).follow, "storage guard")
        yield context


def _cell(settings: Settings) -> Cell:
    if settings.cell_file is not None:
        return read_cell(settings.cell_file)
    return simulated_cell(settings.simulated_scenario, settings.simulated_seed)


def _present(cell: Cell, settings: Settings) -> CurrentCell:
    file = settings.cell_file
    return CurrentCell(cell, None if file is None else lambda: read_cell(file))


async def _simulation(
    cell: Cell, settings: Settings, state: Path, stack: contextlib.AsyncExitStack
) -> Simulation | None:
    faults = settings.simulated_faults
    if cell.simulated is None:
        if faults is not None:
            raise ScenarioRefusedError(
                f"{faults}: faults can be scripted only in a simulated cell; this one is real."
            )
        return None
    pace = settings.simulated_pace if cell.simulated.pace is None else cell.simulated.pace
    running = running_simulation(cell.simulated, pace, state, faults, with_camera=cell.camera is not None)
    return await stack.enter_async_context(running)


def _with_simulated_devices(cell: Cell, simulation: Simulation | None, drivers: DriverRegistry) -> Cell:
    """Return the cell with a device for each instrument of its simulation that a driver speaks to."""
    if simulation is None:
        return cell
    entries: dict[str, DeviceEntry] = {}
    for endpoint in simulation.endpoints:
        if endpoint.device not in _NOT_DEVICES and not _is_further_port(endpoint, simulation):
            for name in _drivers_of(endpoint, drivers):
                options: dict[str, str | int | float | bool] = {"host": endpoint.host, "port": endpoint.port}
                # One ballbar listens at several ports, in a language each: the first one is spoken.
                options |= _further_ports(endpoint, simulation, drivers.plugin(name))
                if _TOOL_FILE in drivers.plugin(name).options:
                    options[_TOOL_FILE] = str(simulation.tool_file)
                entries.setdefault(endpoint.device, DeviceEntry(endpoint.device, name, options))
    return dataclasses.replace(cell, devices=tuple(entries.values()))


def _is_further_port(endpoint: Endpoint, simulation: Simulation) -> bool:
    """Whether an endpoint is one more port of another device, even where a driver could speak to it alone."""
    return any(endpoint.device.startswith(f"{other.device}-") for other in simulation.endpoints)


def _further_ports(endpoint: Endpoint, simulation: Simulation, plugin: DriverPlugin) -> dict[str, int]:
    """Return the further ports of a device as its driver calls them: `script_port` of "robot-script"."""
    ports = {
        f"{other.device.removeprefix(f'{endpoint.device}-')}_port": other.port
        for other in simulation.endpoints
        if other.device.startswith(f"{endpoint.device}-")
    }
    return {option: port for option, port in ports.items() if option in plugin.options}


def _drivers_of(endpoint: Endpoint, drivers: DriverRegistry) -> list[str]:
    return [name for name, plugin in drivers.plugins.items() if plugin.protocol == endpoint.protocol][:1]


def _rack(cell: Cell, simulation: Simulation | None, drivers: DriverRegistry) -> DeviceRegistry:
    kinds = {entry.name: drivers.kind(entry.driver, entry.use) for entry in cell.devices}
    clock_entries = [entry for entry in cell.devices if kinds[entry.name] == "clock"]
    clock = _clock(simulation, clock_entries, drivers)
    mounted = [
        MountedDevice(
            entry=entry,
            kind=kinds[entry.name],
            protocol=drivers.plugin(entry.driver).protocol,
            device=drivers.open(entry.driver, entry.options, clock, use=entry.use),
            expected_serial=cell.expected_serial(kinds[entry.name], entry),
        )
        for entry in cell.devices
        if entry not in clock_entries
    ]
    return DeviceRegistry(mounted, clock)


def _clock(
    simulation: Simulation | None, entries: Sequence[DeviceEntry], drivers: DriverRegistry
) -> FullClock:
    name, options = _REAL_CLOCK, dict[str, str | int | float | bool]()
    if entries:  # a simulated cell on the network brings its clock like its instruments
        name, options = entries[0].driver, dict(entries[0].options)
    elif simulation is not None:
        endpoint = next(e for e in simulation.endpoints if e.device == "clock")
        (name,) = _drivers_of(endpoint, drivers) or [endpoint.protocol]
        options = {"host": endpoint.host, "port": endpoint.port}
    return cast(FullClock, drivers.open(name, options, use="clock"))


def _by_ballbar(session_desk: SessionService, perform: Perform) -> BallbarSessions:
    work = BallbarWork(perform)
    return BallbarSessions(session_desk, work.precalibrator, work.choose)


def _context(
    cell: Cell,
    present: CurrentCell,
    database: Database,
    rack: DeviceRegistry,
    simulation: Simulation | None,
    perform: Perform,
    lookout: HealthMonitor,
    people: PeopleService,
) -> Context:
    sessions, readings = SessionRepository(database), ReadingRepository(database)
    campaigns, jobs = CampaignRepository(database), JobRepository(database)
    results, diagnoses = ResultRepository(database), DiagnosisRepository(database)
    corrections, closings = CorrectionRepository(database), ClosingRepository(database)
    additions, drafts = AddedStopsRepository(database), DraftFolder.beside(database.file)
    job_desk = JobService(jobs, campaigns, results, diagnoses, corrections, perform)
    session_desk = SessionService(sessions, LedgerRepository(database), rack, present)
    contact_sessions, ballbar_sessions = ContactSessions(session_desk), _by_ballbar(session_desk, perform)
    made_of = (ballbar_sessions.campaign, contact_sessions.campaign)
    campaign_desk = CampaignService(campaigns, sessions, readings, *made_of, Uploads())
    again = RepeatedDiagnosis(additions, diagnoses, campaigns, sessions, campaign_desk, job_desk)
    tracker_sessions = TrackerSessions(session_desk, additions, again.after_session)
    return Context(
        version=program_version(),
        cell=cell,
        endpoints=() if simulation is None else simulation.endpoints,
        database=database,
        sessions=sessions,
        readings=readings,
        campaigns=campaigns,
        jobs=jobs,
        results=results,
        diagnoses=diagnoses,
        set_aside=SetAsideRepository(database),
        corrections=corrections,
        closings=closings,
        series=SeriesRepository(database),
        reports=ReportRepository(database),
        work=WorkList(database),
        lineages=Lineages(database),
        events=EventRepository(database),
        rack=rack,
        lookout=lookout,
        session_desk=session_desk,
        tracker_sessions=tracker_sessions,
        ballbar_sessions=ballbar_sessions,
        contact_sessions=contact_sessions,
        guided_sessions=GuidedSessions(tracker_sessions, contact_sessions, readings, Outlooks(perform)),
        hands_desk=SimulatedOperatorService(rack, ballbar_sessions.frame_of),
        faults_desk=FaultService(None if simulation is None else simulation.ask_of_faults, present),
        drawing_desk=Renderer(perform, RenderCache(DrawnFolder.beside(database.file))),
        promise_desk=AccuracyService(perform),
        closing_desk=ClosingService(sessions, closings, rack, present, session_desk.kind_of),
        job_desk=job_desk,
        campaign_desk=campaign_desk,
        people=people,
        draft_desk=DraftService(drafts, campaign_desk.uploads, campaigns, job_desk),
        stopping=asyncio.Event(),
        fault=lambda: None if simulation is None else simulation.fault,
    )


def serve(settings: Settings) -> int:
    """Serve a cell until interrupted, as `run` does."""

    def opened(lines_lost: Callable[[], int]) -> AbstractAsyncContextManager[Context]:
        return open_context(settings, lines_lost=lines_lost)

    return run(settings, ServiceDefinition(opened, create_application))
