"""The journal of one session, on disk; what `truepose.sequencing.tracker.journal.SessionJournal` asks for."""

from truepose.domain.identities import IdentityTaken
from truepose.domain.session import (
    FixedNestTaken,
    PointTaken,
    Progress,
    Registration,
    SessionState,
    StopSkipped,
)
from truepose.storage.measurement.readings import ReadingRepository
from truepose.storage.measurement.sessions import SessionRepository


class StoredJournal:
    """Each call returns once its record is committed."""

    def __init__(self, session_id: int, sessions: SessionRepository, readings: ReadingRepository) -> None:
        self._session_id = session_id
        self._sessions = sessions
        self._readings = readings

    async def writable(self) -> None:
        """Return once records are taken again, after one was refused."""
        await self._sessions.writable()

    async def state_changed(self, state: SessionState, reason: str, person: str | None) -> None:
        """Keep a change of state."""
        await self._sessions.change_state(self._session_id, state, reason, person)

    async def point_taken(self, point: PointTaken) -> str:
        """Keep a reading of a tool nest; returns its number."""
        return str(await self._readings.add_point(self._session_id, point))

    async def fixed_nest_taken(self, reading: FixedNestTaken) -> str:
        """Keep a reading of a fixed nest; returns its number."""
        return str(await self._readings.add_fixed_nest(self._session_id, reading))

    async def stop_skipped(self, skipped: StopSkipped) -> None:
        """Keep that a configuration was not measured, and why."""
        await self._sessions.skip(self._session_id, skipped)

    async def registered(self, registration: Registration) -> None:
        """Keep the tracker's place in the world."""
        await self._sessions.register(self._session_id, registration)

    async def identified(self, taken: IdentityTaken) -> None:
        """Keep which device answered."""
        await self._sessions.identify(self._session_id, taken)

    async def progressed(self, progress: Progress) -> None:
        """Keep how far the session is."""
        await self._sessions.tell_progress(self._session_id, progress)

    async def noted(self, text: str) -> None:
        """Keep a sentence."""
        await self._sessions.note(self._session_id, text)
