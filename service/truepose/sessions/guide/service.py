"""Sessions that run by themselves, for the tablets that follow them: seen, followed, and acted upon."""

import asyncio
from collections.abc import Sequence

from truepose.analysis.campaigns.records import measured_session
from truepose.analysis.job_queue.accuracy_tasks import SessionForecast
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.ledger import LedgerEntry
from truepose.messages.message import message
from truepose.sessions.contact.runner import ContactRunner
from truepose.sessions.contact.service import ContactSessions
from truepose.sessions.errors import NotNowError
from truepose.sessions.guide.guide import Fixed, Guide, Outlooks, standing, standing_of
from truepose.sessions.guide.reading_tables import Sheet, sheet_of
from truepose.sessions.guide.scene import GuidedScene, guided_scene
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.sessions.tracker.service import TrackerSessions
from truepose.storage.ledger.tracker_readings import ReadingRepository


class GuidedSessions:
    """Sessions with a tracker, a camera or gauges, behind one face."""

    def __init__(
        self,
        tracker: TrackerSessions,
        contacts: ContactSessions,
        readings: ReadingRepository,
        outlooks: Outlooks,
    ) -> None:
        self._tracker = tracker
        self._contacts = contacts
        self._readings = readings
        self._outlooks = outlooks
        self._desk = tracker.desk

    async def guide(self, session_id: int) -> Guide:
        """Return a session as it stands; raises NotFoundError, and NotNowError for one with the ballbar."""
        fixed = await self._fixed(session_id)
        kept, now = await self._desk.lines_and_attendance(session_id)
        runner = self._running(session_id)
        if runner is None:
            found = standing(fixed, (line.entry for line in kept), runs=False)
            return Guide(session_id, fixed, found, now)
        foreign = runner.tracker_in_question if isinstance(runner, TrackerRunner) else None
        return Guide(session_id, fixed, standing_of(fixed, runner.record, runs=True), now, foreign)

    async def sheet(self, session_id: int) -> Sheet:
        """Return what a session has read so far; raises as `guide`."""
        fixed = await self._fixed(session_id)
        return await asyncio.to_thread(sheet_of, fixed, await self._entries(session_id))

    async def scene(self, session_id: int) -> GuidedScene:
        """Return what to draw of a session; raises as `guide`."""
        fixed = await self._fixed(session_id)
        step = (await self.guide(session_id)).standing.step
        registration = await self._desk.sessions.registration(session_id)
        config = None if step is None else step.config
        return await asyncio.to_thread(guided_scene, fixed, registration, config)

    async def outlook(self, session_id: int) -> SessionForecast | None:
        """Return what the readings so far promise; None where they are too few, or none of a calibration.

        Raises as `guide`, and what the worker raises.
        """
        fixed = await self._fixed(session_id)
        if fixed.role != "calibration":  # of a tracker or a camera: no other kind has this role
            return None
        progress = (await self.guide(session_id)).standing.progress
        left = max(0, progress.planned - progress.done - progress.skipped)
        session = await measured_session(self._desk.sessions, self._readings, session_id)
        return await self._outlooks.of(session, left)

    async def _entries(self, session_id: int) -> Sequence[LedgerEntry]:
        return [line.entry for line in await self._desk.ledger.whole(session_id)]

    async def _fixed(self, session_id: int) -> Fixed:
        record, sessions = await self._desk.sessions.get(session_id), self._desk.sessions
        plan = await self._desk.kind_of(record).stored_plan(session_id)
        if isinstance(plan, BallbarPlan):
            raise NotNowError(message("session.refused.guide_of_ballbar", session=session_id))
        return Fixed(record.name, record.role, await sessions.setup(session_id), plan)

    def _running(self, session_id: int) -> TrackerRunner | ContactRunner | None:
        return self._tracker.running(session_id) or self._contacts.running(session_id)
