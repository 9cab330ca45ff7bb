"""What the ledger amounts to and how long steps took, as far as that is the same for every kind."""

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import fmean, median
from typing import Final, Self

from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import IdentityOf, IdentityTaken, SessionState, config_of
from truepose.messages.message import Text, message
from truepose.sessions.engine.identity_check import KnownDevice

_FAR_OFF: Final = 3.0  # times the median


@dataclass(slots=True)
class StepTimes:
    """How long the steps took, in cell time; only the time in which the session ran counts."""

    elapsed_s: float = 0.0
    _last_s: float | None = None
    _ended_s: float = 0.0  # elapsed when the step before ended
    _taken_s: dict[StrEnum, list[float]] = field(default_factory=dict)

    def tick(self, now_s: float, *, running: bool) -> None:
        """Let time pass until `now_s`."""
        if running and self._last_s is not None:
            # A cell's clock may begin anew with its simulation; time never runs back for a session.
            self.elapsed_s += max(0.0, now_s - self._last_s)
        self._last_s = now_s

    def end_step(self, kind: StrEnum | None) -> None:
        """Count the time since the step before as that of a step of this kind."""
        if kind is not None:
            self._taken_s.setdefault(kind, []).append(self.elapsed_s - self._ended_s)
        self._ended_s = self.elapsed_s

    @property
    def in_step_s(self) -> float:
        """How long the present step has been under way."""
        return self.elapsed_s - self._ended_s

    def mean_s(self, kind: StrEnum) -> float | None:
        """Return the mean time of steps of a kind, which their sum follows; None before the first.

        One far off the others is none of a usual step: a fault, a search, somebody who helped.
        """
        taken = self._taken_s.get(kind)
        if not taken:
            return None
        usual = _FAR_OFF * median(taken)
        return fmean([time_s for time_s in taken if time_s <= usual] or taken)

    def median_s(self, kinds: Iterable[StrEnum], at_least: int = 1) -> float | None:
        """Return the median time of steps of these kinds; None before there were enough of them."""
        taken = [time_s for kind in kinds for time_s in self._taken_s.get(kind, ())]
        return median(taken) if len(taken) >= at_least else None


WAITS: Final = message("session.doing.wait")  # for a person
FINISHED: Final = message("session.doing.finished")
_ENDS: Final = frozenset({EntryKind.MEASURED, EntryKind.SKIPPED})


@dataclass(frozen=True, slots=True)
class ActingTablet:
    """The one tablet whose acts count, and who holds it."""

    tablet: str
    person: str


@dataclass(slots=True)
class Record(ABC):
    """The ledger so far; `apply` takes the next line, and no line is ever taken back."""

    state: SessionState = SessionState.PLANNED
    reason: Text = ""  # why this state was entered
    acting: ActingTablet | None = None
    devices: dict[IdentityOf, KnownDevice] = field(default_factory=dict)
    identities: list[IdentityTaken] = field(default_factory=list)
    keys: dict[str, int] = field(default_factory=dict)  # idempotency key -> place in the ledger, from 0
    times: StepTimes = field(default_factory=StepTimes)
    lines: int = 0
    last_end: LedgerEntry | None = None  # of a configuration
    ends: int = 0  # of configurations

    @classmethod
    def of(cls, entries: Iterable[LedgerEntry]) -> Self:
        """Return what these lines amount to, oldest first."""
        record = cls()
        for entry in entries:
            record.apply(entry)
        return record

    def apply(self, entry: LedgerEntry) -> None:
        """Take the next line of the ledger."""
        # The time in which the service was off is nobody's pace.
        was_off = entry.control is Control.RESTARTED
        self.times.tick(entry.time_s, running=self.state is SessionState.RUNNING and not was_off)
        if entry.key is not None:
            # The first line with a key is the act; a refused answer may have made it come again.
            self.keys.setdefault(entry.key, self.lines)
        self.lines += 1
        if entry.identity is not None:
            self.identities.append(entry.identity)
            self.devices[entry.identity.device] = self.known(entry.identity.device).after(entry.identity)
        if entry.kind in _ENDS and config_of(entry.step_id) is not None:
            self.last_end = entry
            self.ends += 1
        # Before the state is entered: a line may end a step and the session with it, and the step was done in
        # the state before.
        self.take(entry)
        if entry.entered is not None:
            self.enter(entry.entered, entry.text)

    def known(self, device: IdentityOf) -> KnownDevice:
        """Return what the session knows of one of its devices."""
        return self.devices.get(device, KnownDevice())

    @abstractmethod
    def take(self, entry: LedgerEntry) -> None:
        """Take what a line says of the steps of the session."""

    @abstractmethod
    def enter(self, state: SessionState, reason: Text) -> None:
        """Enter a state."""
