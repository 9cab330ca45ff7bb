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
    from truepose.analysis.campaigns.stored import CampaignDesk
    from truepose.analysis.drafts import DraftDesk
    from truepose.analysis.drawing import DrawingDesk
    from truepose.analysis.jobs import JobDesk
    from truepose.analysis.promising import PromiseDesk
    from truepose.domain.cell.description import Cell
    from truepose.operation.ballbar.sessions import BallbarSessions
    from truepose.operation.closing import ClosingDesk
    from truepose.operation.contacts.sessions import ContactSessions
    from truepose.operation.devices import Rack
    from truepose.operation.guided.sessions import GuidedSessions
    from truepose.operation.lookout.watch import Lookout
    from truepose.operation.people.desk import PeopleDesk
    from truepose.operation.sessions import SessionDesk
    from truepose.operation.simulated_faults import FaultsDesk
    from truepose.operation.simulated_hands import HandsDesk
    from truepose.operation.tracker.sessions import TrackerSessions
    from truepose.storage.calibration.campaigns import CampaignRepository
    from truepose.storage.calibration.corrections import CorrectionRepository
    from truepose.storage.calibration.diagnoses import DiagnosisRepository
    from truepose.storage.calibration.jobs import JobRepository
    from truepose.storage.calibration.reports import ReportRepository
    from truepose.storage.calibration.results import ResultRepository
    from truepose.storage.database import Database
    from truepose.storage.events import EventRepository
    from truepose.storage.measurement.closings import ClosingRepository
    from truepose.storage.measurement.series import SeriesRepository
    from truepose.storage.measurement.sessions import SessionRepository
    from truepose.storage.measurement.tracker_readings import ReadingRepository
    from truepose.storage.records import SessionRecord
    from truepose.storage.work.lineage import Lineages
    from truepose.storage.work.listing import WorkList


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
    corrections: CorrectionRepository
    closings: ClosingRepository
    series: SeriesRepository
    reports: ReportRepository
    work: WorkList
    lineages: Lineages
    events: EventRepository
    rack: Rack
    lookout: Lookout
    session_desk: SessionDesk
    tracker_sessions: TrackerSessions
    ballbar_sessions: BallbarSessions
    contact_sessions: ContactSessions
    guided_sessions: GuidedSessions
    hands_desk: HandsDesk
    faults_desk: FaultsDesk
    closing_desk: ClosingDesk
    drawing_desk: DrawingDesk
    promise_desk: PromiseDesk
    job_desk: JobDesk
    campaign_desk: CampaignDesk
    people: PeopleDesk
    draft_desk: DraftDesk
    stopping: asyncio.Event  # set when the service ends: streams end with it
    fault: Callable[[], str | None]  # why the simulated cell does not run any more

    def asked_sessions(self, record: SessionRecord) -> TrackerSessions | ContactSessions:
        """Return what runs sessions like this one; those with the ballbar have routes of their own."""
        return self.contact_sessions if self.contact_sessions.owns(record) else self.tracker_sessions

    @property
    def simulated(self) -> bool:
        """Whether no robot and no instrument are behind all this."""
        return self.cell.simulated is not None


async def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


Here = Annotated[Context, Depends(_context)]
