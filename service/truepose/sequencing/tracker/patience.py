"""What a session does while its records are refused: it keeps them, says so, and tries again.

Nothing moves meanwhile: whoever moves the arm waits here for the record of what came before. What was read
stays in memory until it is on disk; only then does anything follow from it.
"""

from collections.abc import Awaitable, Callable
from typing import TypeVar

from truepose.domain.errors import RecordRefusedError
from truepose.domain.identities import IdentityTaken
from truepose.domain.session import (
    FixedNestTaken,
    PointTaken,
    Progress,
    Registration,
    SessionState,
    StopSkipped,
)
from truepose.sequencing.tracker.journal import SessionJournal

T = TypeVar("T")


def trouble_with(error: RecordRefusedError) -> str:
    """Return what a person is told while records are refused."""
    return (
        f"The database cannot be written ({str(error).rstrip('.')}). Nothing moves. "
        "What was measured is kept and written as soon as that is possible."
    )


class PatientJournal:
    """A journal that returns once the record is kept, however often it was refused before."""

    def __init__(self, journal: SessionJournal) -> None:
        self._journal = journal
        self.trouble: str | None = None  # what is said while a record waits; None where none does
        self.interrupted: str | None = None  # why records were refused since a person last confirmed

    def forget(self) -> None:
        """Forget what was refused before: a person has looked at the cell since."""
        self.interrupted = None

    async def keep(self, write: Callable[[], Awaitable[T]]) -> T:
        """Return what `write` returns, once it is not refused any more."""
        while True:
            try:
                kept = await write()
            except RecordRefusedError as error:
                self.trouble, self.interrupted = trouble_with(error), str(error)
                await self._journal.writable()
            else:
                self.trouble = None
                return kept

    async def writable(self) -> None:
        """Return at once: whoever waits for this journal waits for the record itself."""

    async def state_changed(self, state: SessionState, reason: str, person: str | None) -> None:
        """Keep a change of state."""
        await self.keep(lambda: self._journal.state_changed(state, reason, person))

    async def point_taken(self, point: PointTaken) -> str:
        """Keep a reading of a tool nest; returns the reading's id."""
        return await self.keep(lambda: self._journal.point_taken(point))

    async def fixed_nest_taken(self, reading: FixedNestTaken) -> str:
        """Keep a reading of a fixed nest; returns the reading's id."""
        return await self.keep(lambda: self._journal.fixed_nest_taken(reading))

    async def stop_skipped(self, skipped: StopSkipped) -> None:
        """Keep that a configuration was not measured, and why."""
        await self.keep(lambda: self._journal.stop_skipped(skipped))

    async def registered(self, registration: Registration) -> None:
        """Keep the tracker's place in the world."""
        await self.keep(lambda: self._journal.registered(registration))

    async def identified(self, taken: IdentityTaken) -> None:
        """Keep who a device said that it is, or that a person accepted it."""
        await self.keep(lambda: self._journal.identified(taken))

    async def progressed(self, progress: Progress) -> None:
        """Tell how far the session is."""
        await self.keep(lambda: self._journal.progressed(progress))

    async def noted(self, text: str) -> None:
        """Keep a sentence."""
        await self.keep(lambda: self._journal.noted(text))
