"""What a session needs kept: implemented by the storage, and by a list in the tests."""

from dataclasses import dataclass
from typing import Protocol

from truepose.domain.identities import IdentityTaken
from truepose.domain.session import (
    FixedNestTaken,
    PointTaken,
    Progress,
    Registration,
    SessionState,
    StopSkipped,
)


class SessionJournal(Protocol):
    """Keeps what happens in one session, in the order of the calls.

    Every method returns only when its record is on disk; the runner acknowledges nothing earlier and moves
    nothing while a call is open. RecordRefusedError has the session wait and the record tried again; a method
    that raises anything else ends the session as failed.
    """

    async def writable(self) -> None:
        """Return once records are taken again, after one was refused."""
        ...

    async def state_changed(self, state: SessionState, reason: str, person: str | None) -> None:
        """Keep a change of state; `person` is who asked or confirmed, None where nobody did."""
        ...

    async def point_taken(self, point: PointTaken) -> str:
        """Keep a reading of a tool nest; returns the reading's id."""
        ...

    async def fixed_nest_taken(self, reading: FixedNestTaken) -> str:
        """Keep a reading of a fixed nest; returns the reading's id."""
        ...

    async def stop_skipped(self, skipped: StopSkipped) -> None:
        """Keep that a configuration was not measured, and why."""
        ...

    async def registered(self, registration: Registration) -> None:
        """Keep the tracker's place in the world; a later one supersedes the earlier from then on."""
        ...

    async def identified(self, taken: IdentityTaken) -> None:
        """Keep which device answered, or that a person accepted it."""
        ...

    async def progressed(self, progress: Progress) -> None:
        """Tell how far the session is."""
        ...

    async def noted(self, text: str) -> None:
        """Keep a sentence for the report and the operator."""
        ...


@dataclass(frozen=True, slots=True)
class SessionHistory:
    """What earlier runs of this session have on disk; the default is a session that never ran."""

    state: SessionState = SessionState.PLANNED
    points: tuple[PointTaken, ...] = ()
    skipped: tuple[StopSkipped, ...] = ()
    registration: Registration | None = None  # the latest
    identities: tuple[IdentityTaken, ...] = ()  # oldest first
    elapsed_s: float = 0.0  # as the last Progress said

    @property
    def done(self) -> frozenset[int]:
        """Numbers of the configurations to which the arm does not go again."""
        return frozenset([p.config for p in self.points] + [s.config for s in self.skipped])
