"""The ledger of a session: every line is on disk before anything follows from it."""

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, Generic, Protocol, TypeAlias, TypeVar

from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.people import tidy_name
from truepose.domain.session import IdentityOf, IdentityTaken, SessionState
from truepose.messages.message import Message, Text, message
from truepose.sessions.engine.commands import CommandOutcome, OperatorCommand
from truepose.sessions.engine.identity_check import judge, sentence
from truepose.sessions.engine.progress import Record
from truepose.sessions.engine.states import ASKS, after_restart, require_transition
from truepose_drivers.api import Clock, DeviceIdentity
from truepose_drivers.errors import DriverError


class Ledger(Protocol):
    """Append-only; what an earlier run appended comes back as the entries that the runner is built with."""

    async def append(self, entry: LedgerEntry) -> int:
        """Keep a line and return its number once it is on disk; a repeated key changes nothing.

        Raises RecordRefusedError where it cannot be kept now.
        """
        ...

    async def writable(self) -> None:
        """Return once lines are taken again, after one was refused."""
        ...


S = TypeVar("S")
RESTARTED: Final = message("session.restarted")
_KEPT_BEFORE: Final = message("session.done_before")


class Logbook(Generic[S]):
    """Appends lines and knows the situation that follows; who appends holds `changing`.

    `record` takes the lines, `describe` makes a situation of it.
    """

    def __init__(
        self,
        ledger: Ledger,
        clock: Clock,
        record: Record,
        describe: Callable[[], S],
        entries: tuple[LedgerEntry, ...],
    ) -> None:
        self._ledger = ledger
        self._clock = clock
        self._entries = list(entries)
        self.record = record
        self._describe = describe
        for entry in entries:
            record.apply(entry)
        self._restarted_as = self._state_after_restart()
        if self._restarted_as is not None:
            # In memory at once, on record by `open`: nothing may be done in the state of an earlier run.
            record.enter(self._restarted_as, RESTARTED)
        self._outcomes: dict[str, CommandOutcome] = {}  # by key, of this run
        self._changed = asyncio.Event()
        # Whoever appends looks at the situation first; without the lock two acts could both find what only
        # one of them may do.
        self.changing = asyncio.Lock()  # lines reach the ledger one at a time
        self.trouble: Text | None = None  # what is said while lines are refused; nothing moves meanwhile
        self.cause_of_trouble: RecordRefusedError | None = None  # while it lasts
        self.refused = asyncio.Event()  # set as long as that lasts
        self.interrupted: Text | None = None  # why lines were refused since a person last had it go on
        # A number and not an event: whoever was busy while something changed sees that from the number.
        self.version = 0
        self.prompt_id: int | None = None  # the line of this run that asks what a person is asked now
        self.situation = describe()

    def _state_after_restart(self) -> SessionState | None:
        """Return the state that a restart puts the session in; None where it makes no difference."""
        state = self.record.state
        if state is SessionState.AWAITING_CONFIRMATION:  # the question is put again
            return state
        return None if after_restart(state) is state else after_restart(state)

    @property
    def state(self) -> SessionState:
        """Where the session stands."""
        return self.record.state

    @property
    def entries(self) -> tuple[LedgerEntry, ...]:
        """Every line so far."""
        return tuple(self._entries)

    async def open(self, **line: Any) -> None:
        """Record, once, that the service was started anew where an earlier run had begun the session."""
        if self._restarted_as is not None:
            said = {"entered": self._restarted_as, "text": RESTARTED, **line}
            await self.append(EntryKind.CONTROL, control=Control.RESTARTED, **said)
            self._restarted_as = None

    @property
    def restarted(self) -> bool:
        """Whether an earlier run had begun the session, and that is not on record yet."""
        return self._restarted_as is not None

    async def append(
        self, kind: EntryKind, step_id: str = "", act: OperatorCommand | None = None, **fields: Any
    ) -> int:
        """Keep a line; returns its number. What follows from it is seen once it is on disk.

        Raises RecordRefusedError where it cannot be kept now; then it was not, and nothing follows.
        """
        acting = self.record.acting
        time_s = fields.pop("time_s", None)
        # The cell's clock and not the computer's: a simulated cell keeps its own time, and paces are learnt
        # from these stamps.
        entry = LedgerEntry(step_id, kind, await self._now_s() if time_s is None else time_s, **fields)
        if act is not None:
            entry = replace(
                entry, person=tidy_name(act.person) or None, tablet=act.tablet or None, key=act.key
            )
        elif acting is not None:
            entry = replace(entry, person=acting.person, tablet=acting.tablet)
        # Everything below is after the commit: what is refused has no consequence in memory either.
        number = await self._keep(entry)
        self._entries.append(entry)
        self.record.apply(entry)
        self.situation = self._describe()
        # The number of the line is the name of the question, so that the same question asked twice is two
        # (decision 0037).
        if entry.entered in ASKS or entry.kind is EntryKind.SHOWN:
            self.prompt_id = number
        elif entry.entered is not None:
            self.prompt_id = None
        # A person has looked since the refusal, and let it go on.
        if entry.entered is SessionState.RUNNING:
            self.interrupted = None
        self.tell()
        return number

    async def write(self, kind: EntryKind, step_id: str = "", **fields: Any) -> None:
        """Keep a line, again where it was refused."""

        async def append() -> None:
            await self.append(kind, step_id, **fields)

        await self.keep(append)

    async def keep(self, work: Callable[[], Awaitable[None]]) -> None:
        """Do what appends lines, again where one was refused; nothing moves in between."""
        while True:
            with contextlib.suppress(RecordRefusedError):
                # The lock is let go before the wait: a person has to be heard while the disk refuses
                # (decision 0024).
                async with self.changing:
                    return await work()
            await self.accepted()

    async def accepted(self) -> None:
        """Return once lines are taken again; at once where none was refused."""
        if self.refused.is_set():
            await self._ledger.writable()
            self._take_note(None)

    async def _now_s(self) -> float:
        """Return the cell's time; where its clock does not answer, that of the line before."""
        try:
            return await self._clock.now_s()
        except DriverError:
            # A line must not fail for its time: what it says cannot be read again.
            return self._entries[-1].time_s if self._entries else 0.0

    async def _keep(self, entry: LedgerEntry) -> int:
        try:
            number = await self._ledger.append(entry)
        except RecordRefusedError as error:
            # `interrupted` stays when lines are taken again: after a refusal the next motion wants a person.
            self.interrupted, self.cause_of_trouble = error.text, error
            self._take_note(_trouble_with(error))
            raise
        self.cause_of_trouble = None
        self._take_note(None)
        return number

    def _take_note(self, trouble: Text | None) -> None:
        if trouble == self.trouble:
            return
        self.trouble = trouble
        if trouble is None:
            self.refused.clear()
        else:
            self.refused.set()
        self.tell()

    async def enter(
        self,
        state: SessionState,
        reason: Text,
        act: OperatorCommand | None = None,
        step_id: str = "",
        **fields: Any,
    ) -> int:
        """Record a change of state; raises NotNowError where no such change is possible."""
        require_transition(self.state, state)
        return await self.append(EntryKind.CONTROL, step_id, act, entered=state, text=reason, **fields)

    def keep_outcome(self, key: str | None, outcome: CommandOutcome) -> CommandOutcome:
        """Remember what came of a request."""
        if key is not None:
            self._outcomes[key] = outcome
        return outcome

    async def earlier_outcome(self, key: str | None) -> CommandOutcome | None:
        """Return what came of a request with this key before; None where it is new."""
        if key is None or key in self._outcomes:
            return None if key is None else self._outcomes[key]
        place = self.record.keys.get(key)
        if place is None:
            return None
        # Only the ledger knows the number of a line of an earlier run; it answers a key that it has with that
        # number, and appends nothing.
        return CommandOutcome(_KEPT_BEFORE, await self._ledger.append(self._entries[place]))

    def knows(self, key: str | None) -> bool:
        """Whether a request with this key was answered, in this run or in an earlier one."""
        return key in self._outcomes or key in self.record.keys

    def refresh(self) -> None:
        """Look anew at where the session stands: its plan has changed."""
        self.situation = self._describe()
        self.tell()

    def tell(self) -> None:
        """Wake everybody who waits for a change."""
        self.version += 1
        self._changed.set()
        self._changed = asyncio.Event()

    async def changed(self, after: int) -> int:
        """Return the version once it is above `after`."""
        while self.version <= after:
            await self._changed.wait()
        return self.version


def _trouble_with(error: RecordRefusedError) -> Message:
    return message("session.database.is", why=error.text)


Heard: TypeAlias = Callable[[IdentityOf, DeviceIdentity], None]


def _nobody_listens(device: IdentityOf, identity: DeviceIdentity) -> None:
    pass


@dataclass(frozen=True, slots=True)
class Expected:
    """What the cell file says now of its devices, and who wants to hear what they answer."""

    serials: Mapping[IdentityOf, str] = field(default_factory=dict)  # what it does not name may be any
    heard: Heard = _nobody_listens


class IdentityCheck:
    """Judges who answered; who keeps what was found lets one append at a time."""

    def __init__(self, expected: Expected, logbook: Logbook[Any]) -> None:
        self._expected = expected
        self._logbook = logbook

    def news(self, device: IdentityOf, identity: DeviceIdentity | None) -> IdentityTaken | None:
        """Return what an answer says that is new, None where it says nothing new or nobody answered yet."""
        if identity is None:
            return None
        known = self._logbook.record.known(device)
        return judge(device, identity.serial, self._expected.serials.get(device, ""), known)

    def hear(self, device: IdentityOf, identity: DeviceIdentity) -> None:
        """Tell whoever wants to know what a device answered."""
        self._expected.heard(device, identity)

    async def keep(self, taken: IdentityTaken) -> None:
        """Put what was found on record."""
        await self._logbook.append(EntryKind.CONTROL, text=sentence(taken), identity=taken)
