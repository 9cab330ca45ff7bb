"""Sessions that run by themselves, for the tablets that follow them: seen, followed, and acted upon."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from dataclasses import replace

from truepose.analysis.campaigns.measured import measured_session
from truepose.analysis.workers.outlook import Outlook
from truepose.domain.measurement.ledger import LedgerEntry
from truepose.operation.contacts.sessions import ContactSessions
from truepose.operation.followers import change
from truepose.operation.guided.guide import Fixed, Guide, Standing, standing, standing_of
from truepose.operation.guided.outlooks import Outlooks
from truepose.operation.guided.scene import GuidedScene, guided_scene
from truepose.operation.guided.sheet import Sheet, sheet_of
from truepose.operation.tracker.sessions import TrackerSessions
from truepose.sequencing.contacts.runner import ContactRunner
from truepose.sequencing.engine.acts import Act
from truepose.sequencing.engine.states import ASKS
from truepose.sequencing.errors import NotNowError
from truepose.sequencing.tracker.measuring.watching import Sighting
from truepose.sequencing.tracker.runner import TrackerRunner
from truepose.storage.measurement.tracker_readings import ReadingRepository
from truepose.storage.records import ActAnswer, RequestKey, SessionRecord


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

    async def act(self, session_id: int, act: Act, key: RequestKey) -> ActAnswer:
        """Do what a person asks for, once for each key; raises what the session's kind raises."""
        if self._contacts.owns(await self._get(session_id)):
            return await self._contacts.act(session_id, act, key)
        return await self._tracker.act(session_id, act, key)

    async def guide(self, session_id: int) -> Guide:
        """Return a session as it stands; raises NotFoundError, and NotNowError for one with the ballbar."""
        fixed, runner = await self._fixed(session_id), self._running(session_id)
        under_way = self._desk.under_way(session_id)
        if runner is None or under_way is None:
            kept = await self._desk.ledger.whole(session_id)
            found = standing(fixed, (line.entry for line in kept), runs=False)
            asked = found.reason if found.state in ASKS else None
            return replace(
                self._guide(session_id, fixed, found, kept[-1].id if kept else None), question=asked
            )
        found, now = standing_of(fixed, runner.record, runs=True), runner.moment
        return replace(
            self._guide(session_id, fixed, found, under_way.ledger.newest),
            question=now.question,
            prompt_id=now.prompt_id,
            trouble=now.trouble,
            robot_moving=runner.is_moving,
            tracker_in_question=runner.tracker_in_question if isinstance(runner, TrackerRunner) else None,
        )

    def _guide(self, session_id: int, fixed: Fixed, found: Standing, newest: int | None) -> Guide:
        return Guide(
            id=session_id,
            fixed=fixed,
            standing=found,
            newest_entry=newest,
            watching=self._desk.watching.count(session_id),
            motion_notice=self._desk.rack.motion_notice,
            people=self._desk.present.people,
        )

    async def follow(self, session_id: int) -> AsyncIterator[Guide]:
        """Yield a session as it stands now and whenever that changes; raises as `guide`."""
        while True:
            news, runner = self._desk.watching.news, self._running(session_id)
            version = None if runner is None else runner.version
            yield await self.guide(session_id)
            await change(news, runner, version)

    async def sightings(self, session_id: int) -> AsyncIterator[Sighting]:
        """Yield where the reflector is, as long as a session with a tracker is under way."""
        while True:
            news, runner = self._desk.watching.news, self._running(session_id)
            if isinstance(runner, TrackerRunner):
                async for sighting in runner.live():
                    yield sighting
            await news.wait()  # also behind a run that is over, until there is another one

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

    async def outlook(self, session_id: int) -> Outlook | None:
        """Return what the readings so far promise; None where they are too few, or none of a calibration.

        Raises as `guide`, and what the worker raises.
        """
        fixed = await self._fixed(session_id)
        if fixed.kind == "contacts" or fixed.role != "calibration":
            return None
        progress = (await self.guide(session_id)).standing.progress
        left = max(0, progress.planned - progress.done - progress.skipped)
        session = await measured_session(self._desk.sessions, self._readings, session_id)
        return await self._outlooks.of(session, left)

    async def _entries(self, session_id: int) -> Sequence[LedgerEntry]:
        return [line.entry for line in await self._desk.ledger.whole(session_id)]

    async def _get(self, session_id: int) -> SessionRecord:
        record = await self._desk.sessions.get(session_id)
        if record.role == "ballbar":
            raise NotNowError(
                f"Session {session_id} is one with the ballbar; ballbar-sessions/{session_id} guides it."
            )
        return record

    async def _fixed(self, session_id: int) -> Fixed:
        record, sessions = await self._get(session_id), self._desk.sessions
        is_of_contacts = self._contacts.owns(record)
        plan = await (sessions.contact_plan(session_id) if is_of_contacts else sessions.plan(session_id))
        return Fixed(record.name, record.role, await sessions.setup(session_id), plan)

    def _running(self, session_id: int) -> TrackerRunner | ContactRunner | None:
        return self._tracker.running(session_id) or self._contacts.running(session_id)
