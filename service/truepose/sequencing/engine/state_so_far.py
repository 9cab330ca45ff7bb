"""What the ledger amounts to, line by line, as far as that is the same for every kind of session."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Final

from truepose.domain.measurement.identities import IdentityOf, IdentityTaken
from truepose.domain.measurement.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.measurement.session import SessionState, config_of
from truepose.sequencing.engine.identity.expected import KnownDevice
from truepose.sequencing.engine.pace import StepTimes

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
    reason: str = ""  # why this state was entered
    acting: ActingTablet | None = None
    devices: dict[IdentityOf, KnownDevice] = field(default_factory=dict)
    identities: list[IdentityTaken] = field(default_factory=list)
    keys: dict[str, int] = field(default_factory=dict)  # idempotency key -> place in the ledger, from 0
    times: StepTimes = field(default_factory=StepTimes)
    lines: int = 0
    last_end: LedgerEntry | None = None  # of a configuration
    ends: int = 0  # of configurations

    def apply(self, entry: LedgerEntry) -> None:
        """Take the next line of the ledger."""
        was_off = entry.control is Control.RESTARTED
        self.times.tick(entry.time_s, running=self.state is SessionState.RUNNING and not was_off)
        if entry.key is not None:
            self.keys.setdefault(entry.key, self.lines)
        self.lines += 1
        if entry.identity is not None:
            self.identities.append(entry.identity)
            self.devices[entry.identity.device] = self.known(entry.identity.device).after(entry.identity)
        if entry.kind in _ENDS and config_of(entry.step_id) is not None:
            self.last_end = entry
            self.ends += 1
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
    def enter(self, state: SessionState, reason: str) -> None:
        """Enter a state."""
