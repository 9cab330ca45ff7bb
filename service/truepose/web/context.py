"""What the routes work with; made once by the composition root.

What it holds is loaded by who makes it: routes that a plant has as well know it by name alone.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, cast

from fastapi import Depends, Request

if TYPE_CHECKING:
    from truepose.analysis.campaigns.records import CampaignService
    from truepose.analysis.drafts import DraftService
    from truepose.analysis.jobs import JobService
    from truepose.analysis.page_services import AccuracyService, Renderer
    from truepose.domain.cell import Cell
    from truepose.health import HealthMonitor
    from truepose.people.accounts import PeopleService
    from truepose.sessions.ballbar.service import BallbarSessions
    from truepose.sessions.closing import ClosingService
    from truepose.sessions.contact.service import ContactSessions
    from truepose.sessions.devices import DeviceRegistry
    from truepose.sessions.guide.service import GuidedSessions
    from truepose.sessions.service import SessionService
    from truepose.sessions.simulated import FaultService, SimulatedOperatorService
    from truepose.sessions.tracker.service import TrackerSessions
    from truepose.storage.database import Database
    from truepose.storage.ledger.added_stops import ClosingRepository
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


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Where one instrument of a simulated cell listens."""

    device: str
    protocol: str
    host: str
    port: int


@dataclass(frozen=True, slots=True)
class Context:
    """Everything behind the routes."""

    version: str
    cell: Cell
    endpoints: tuple[Endpoint, ...]  # of the simulated cell; empty for a real one
    database: Database
    sessions: SessionRepository
    readings: ReadingRepository
    campaigns: CampaignRepository
    jobs: JobRepository
    results: ResultRepository
    diagnoses: DiagnosisRepository
    set_aside: SetAsideRepository
    corrections: CorrectionRepository
    closings: ClosingRepository
    series: SeriesRepository
    reports: ReportRepository
    work: WorkList
    lineages: Lineages
    events: EventRepository
    rack: DeviceRegistry
    lookout: HealthMonitor
    session_desk: SessionService
    tracker_sessions: TrackerSessions
    ballbar_sessions: BallbarSessions
    contact_sessions: ContactSessions
    guided_sessions: GuidedSessions
    hands_desk: SimulatedOperatorService
    faults_desk: FaultService
    closing_desk: ClosingService
    drawing_desk: Renderer
    promise_desk: AccuracyService
    job_desk: JobService
    campaign_desk: CampaignService
    people: PeopleService
    draft_desk: DraftService
    stopping: asyncio.Event  # set when the service ends: streams end with it
    fault: Callable[[], str | None]  # why the simulated cell does not run any more

    @property
    def simulated(self) -> bool:
        """Whether no robot and no instrument are behind all this."""
        return self.cell.simulated is not None


async def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


Here = Annotated[Context, Depends(_context)]
