"""What the routes work with; made once by the composition root."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends, Request

from service.analysis.campaigns import CampaignDesk
from service.analysis.jobs import JobDesk
from service.domain.cell import Cell
from service.operation.ballbar_sessions import BallbarDesk
from service.operation.devices import Rack
from service.operation.sessions import SessionDesk
from service.operation.simulated_hands import HandsDesk
from service.storage.campaigns import CampaignRepository
from service.storage.database import Database
from service.storage.diagnoses import DiagnosisRepository
from service.storage.events import EventRepository
from service.storage.jobs import JobRepository
from service.storage.readings import ReadingRepository
from service.storage.results import ResultRepository
from service.storage.sessions import SessionRepository


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
    events: EventRepository
    rack: Rack
    session_desk: SessionDesk
    ballbar_desk: BallbarDesk
    hands_desk: HandsDesk
    job_desk: JobDesk
    campaign_desk: CampaignDesk
    stopping: asyncio.Event  # set when the service ends: streams end with it
    fault: Callable[[], str | None]  # why the simulated cell does not run any more

    @property
    def simulated(self) -> bool:
        """Whether no robot and no instrument are behind all this."""
        return self.cell.simulated is not None


def _context(request: Request) -> Context:
    return cast(Context, request.app.state.context)


Here = Annotated[Context, Depends(_context)]
