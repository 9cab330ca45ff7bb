"""Runs a session of any kind: does the present step, takes what persons ask, keeps every line.

- Nothing is remembered but the ledger: the present step follows from it, also after a restart.
- A halt holds from the moment at which it is asked for; an act with a key is done once.
- A line that the ledger refuses is tried again, and nothing moves meanwhile; a halt holds all the same.
"""

import asyncio
import contextlib
import logging
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Sequence
from dataclasses import replace
from typing import Any, Final, Generic, Protocol, TypeAlias, TypeVar

from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import BALLBAR_OFF, EntryKind
from truepose.domain.session import SessionState
from truepose.messages.message import Text, message
from truepose.sessions.engine.commands import HALTS, LETS_MOVE, CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.halts import Halts, PendingHalts
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.prompts import Prompt
from truepose.sessions.engine.states import Moment, has_ended, words
from truepose.sessions.errors import NotNowError, SessionError
from truepose_drivers.api import GuardsMotion
from truepose_drivers.errors import (
    ConfigurationError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
    NotInitialisedError,
)

_LOG: Final = logging.getLogger(__name__)
Onlooker: TypeAlias = Callable[[], Awaitable[None]]  # called once the session runs, which may end before
_PATIENCE_S: Final = 5.0  # wall time, for an onlooker to leave when the session is over


@contextlib.asynccontextmanager
async def with_onlookers(onlookers: Sequence[Onlooker]) -> AsyncIterator[None]:
    """Let `onlookers` look on meanwhile; none of them ends what is looked at, or keeps it from ending."""
    tasks = [asyncio.create_task(_harmless(onlooker)) for onlooker in onlookers]
    try:
        yield
    finally:
        for task in tasks:
            task.cancel()
        # Waited for with a limit: an onlooker may hang where its driver does, and the devices must be given
        # back all the same.
        if tasks and (await asyncio.wait(tasks, timeout=_PATIENCE_S))[1]:
            _LOG.warning("a monitor did not stop within %g s and was abandoned", _PATIENCE_S)


async def _harmless(onlooker: Onlooker) -> None:
    try:
        await onlooker()
    except Exception:
        _LOG.exception("a monitor failed; the session continues without it")


_JUST_NOW_S: Final = 3.0  # a page says after two that nobody has heard


class Situation(Protocol):
    """What every kind of session says of itself."""

    @property
    def busy(self) -> bool:
        """Whether the present step is done by the program, as soon as nothing forbids it."""
        ...

    @property
    def question(self) -> Text | None:
        """What a person is asked to look at."""
        ...

    @property
    def leads_to(self) -> tuple[int, ...]:
        """Configurations to which the arm may go once that is answered."""
        ...


S = TypeVar("S", bound=Situation)


class SessionRunner(ABC, Generic[S]):
    """One session on one cell; `run` is its task, all other methods may be called from other tasks."""

    def __init__(self, logbook: Logbook[S], halts: Halts, robot: GuardsMotion) -> None:
        """Run what `logbook` keeps; `robot` is moved, with all that stands around its driver."""
        self.robot = robot
        self._logbook = logbook
        self._halts = halts
        self._failure: Exception | None = None  # a halt could not be kept: the run ends with this
        self._pending = PendingHalts(logbook, halts, self.act, self.settle, self.hold)

    @property
    def situation(self) -> S:
        """Where the session stands, as the ledger has it."""
        return self._logbook.situation

    @property
    def state(self) -> SessionState:
        """The state that the session is in, as the ledger has it."""
        return self._logbook.state

    @property
    def prompt(self) -> Prompt | None:
        """What a person is asked to look at, once this run has asked it; None where nothing is asked."""
        now, number = self.situation, self._logbook.prompt_id
        if now.question is None or number is None:
            return None
        answer = CommandName.RESUME if self.state is SessionState.PAUSED else CommandName.CONFIRM
        return Prompt(number, now.question, answer, now.leads_to)

    @property
    def robot_moving(self) -> bool:
        """Whether the arm is in motion, or about to be."""
        return self._halts.moving

    @property
    def trouble(self) -> Text | None:
        """What a person is told while lines are refused; nothing moves meanwhile."""
        return self._logbook.trouble

    @property
    def cause_of_trouble(self) -> RecordRefusedError | None:
        """Why lines are refused; None while they are taken."""
        return self._logbook.cause_of_trouble

    @property
    def moment(self) -> Moment:
        """What the session says of itself now; nothing is awaited, so that all of it is of one moment."""
        return Moment(self.state, self._logbook.record.reason, self.prompt, self.trouble, self.robot_moving)

    @property
    def version(self) -> int:
        """Number of changes so far."""
        return self._logbook.version

    async def changed(self, after: int) -> int:
        """Return the version once it is above `after`."""
        return await self._logbook.changed(after)

    # what a kind of session does in its own way; who calls `do`, `settle` and `hold` holds `changing`

    @abstractmethod
    def require(self, act: OperatorCommand) -> None:
        """Raise PersonMissingError, WatchingTabletError or NotNowError where an act is not allowed now."""

    def lets_move(self, act: OperatorCommand) -> bool:
        """Return whether the arm may move after an act."""
        return act.name in LETS_MOVE

    async def prepare(self, act: OperatorCommand) -> None:
        """Wait for what an act rests on, before it counts."""

    @abstractmethod
    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError and its like where nothing was done."""

    async def begin(self) -> None:
        """Bring a session that is taken up to where it waits."""
        await self._logbook.keep(self._logbook.open)

    @abstractmethod
    async def perform(self) -> None:
        """Do the present step."""

    @abstractmethod
    async def settle(self) -> None:
        """Put on record what follows from the lines so far: the next prompt, or the end."""

    @abstractmethod
    async def hold(self, reason: Text) -> None:
        """Have the session wait for a person: something is not as it was left."""

    @abstractmethod
    async def note_failure(self, error: Exception) -> None:
        """Put a failure of the program on record."""

    def companions(self) -> tuple[Coroutine[Any, Any, None], ...]:
        """Return what goes on while the session is under way, and what it ends with."""
        return ()

    def onlookers(self) -> tuple[Onlooker, ...]:
        """Return what only looks on: whatever becomes of it, the session does not notice."""
        return ()

    async def live(self) -> AsyncIterator[Any]:
        """Yield what the instrument sees from now on until the session ends; for any number of watchers."""
        between_readings: tuple[Any, ...] = ()  # an instrument shows nothing unless its kind says so
        for sample in between_readings:
            yield sample

    async def close(self) -> None:
        """Let go of what was followed."""

    # the same for every kind

    async def act(self, act: OperatorCommand) -> CommandOutcome:
        """Do what a person asks, once for each key; the outcome is on disk when this returns.

        Raises NotNowError, PersonMissingError, ReasonMissingError and WatchingTabletError; nothing was done
        then. Where it cannot be kept RecordRefusedError: a halt of a running session holds and is kept later.
        """
        # Before anything is awaited. A halt that queued for the lock behind a line that waits for the disk
        # would come after the next motion.
        wished = self._wish_at_once(act)
        was_running = self._runs
        try:
            # Without the lock: what an act rests on may come from a loop that needs the lock itself (commit
            # bb119ce6).
            await self.prepare(act)
            async with self._logbook.changing:
                # The restart comes on record before what a person did after it.
                await self._logbook.open()
                # Before every check: a repeated request is answered as it was, also where the act would be
                # refused by now.
                earlier = await self._logbook.earlier_outcome(act.key)
                if earlier is not None:
                    return earlier
                self.require(act)
                self._require_prompt(act)
                self._require_just_pressed(act)
                # "Confirm" is one word for two things: that a step is done, and that the session may go on.
                # One that was sent for the former must not be taken for the latter (decision 0018).
                if act.name is CommandName.CONFIRM and was_running != self._runs:
                    raise NotNowError(  # what was confirmed is not what is asked now
                        message("session.refused.changed_meanwhile", state=words(self.state))
                    )
                # Its own line first: the one with the request's key comes last, so that a kill in between has
                # the whole done again (decision 0016).
                await self._note_ballbar(act)
                return self._logbook.keep_outcome(act.key, await self.do(act))
        # The wish stays: it was asked for, and only its record is missing.
        except RecordRefusedError:
            if wished:
                self._pending.owe(act)
            raise
        # Refused for a reason, so nobody is going to enter that state. A wish of somebody else is left alone.
        except SessionError:
            if wished and self._halts.wish is HALTS[act.name]:
                self._halts.wish = None
            raise
        except Exception as error:
            if wished:  # nobody will enter that state any more, and the arm must not go on either
                self._failure = error
            raise
        finally:
            self._logbook.tell()

    async def note(self, step_id: str, text: Text) -> None:
        """Put a sentence on record; raises RecordRefusedError."""
        async with self._logbook.changing:
            # The restart comes on record before what follows it.
            await self._logbook.open()
            await self._logbook.append(EntryKind.NOTED, step_id, text=text)

    async def ask(self, act: OperatorCommand) -> CommandOutcome:
        """As `act`; a halt that holds although it cannot be kept yet is answered all the same."""
        try:
            return await self.act(act)
        except RecordRefusedError:
            if not self._pending.owes(act):
                raise
            return CommandOutcome(self._halts.not_on_record(act), None)

    async def run(self) -> SessionState:
        """Run to the end and return the state it ended in; first a person has to let it.

        Raises what the ledger raises. Every fault of the devices becomes a state with a sentence; so does a
        mistake of the program, which ends this run.
        """
        async with with_onlookers(self.onlookers()):
            return await self._run()

    async def _run(self) -> SessionState:
        loops: list[asyncio.Task[None]] = []
        try:
            await self.begin()
            # After `begin`: no loop may act on a session that has not said that it was restarted.
            loops += [asyncio.create_task(loop) for loop in self._loops()]
            # Any loop that ends ends the run: a ballbar that nobody follows, or halts that nobody keeps, must
            # not go unnoticed while the arm may move.
            await asyncio.wait(loops, return_when=asyncio.FIRST_COMPLETED)
        except Exception as error:
            await self.note_failure(error)
            raise
        finally:
            for task in loops:
                task.cancel()
            # All of them have ended before the devices are given back: the next session may have them at
            # once.
            results = await asyncio.gather(*loops, return_exceptions=True)
            await self.close()
        for result in results:
            if isinstance(result, Exception):
                await self.note_failure(result)
                raise result
        return self.state

    def _loops(self) -> tuple[Coroutine[Any, Any, None], ...]:
        return self._conduct(), *self.companions(), self._pending.follow()

    @property
    def _ended(self) -> bool:
        return has_ended(self.state)

    @property
    def _runs(self) -> bool:
        return self.state is SessionState.RUNNING

    def _require_prompt(self, act: OperatorCommand) -> None:
        """Raise NotNowError where a person lets the session go on who saw another question."""
        asked = None if self.prompt is None else self.prompt.id
        if act.name in LETS_MOVE and act.prompt_id not in {None, asked}:
            raise NotNowError(message("session.refused.other_prompt", prompt=act.prompt_id))

    def _require_just_pressed(self, act: OperatorCommand) -> None:
        """Raise NotNowError where the person pressed it who looked at the cell a while ago."""
        # A browser that gives a request up leaves its bytes with the network, which delivered a confirmation
        # minutes later, and the robot moved (commit de3038be).
        if self.lets_move(act) and not abs(act.under_way_s) <= _JUST_NOW_S:
            raise NotNowError(message("session.refused.pressed_before"))

    async def _note_ballbar(self, act: OperatorCommand) -> None:
        """Put on record why the ballbar of an earlier session counts as off, before the arm is let move."""
        if act.ballbar_off:
            of_it = replace(act, key=None)  # the key is that of the line which the act itself makes
            await self._logbook.append(EntryKind.NOTED, BALLBAR_OFF, of_it, text=act.ballbar_off)

    def _wish_at_once(self, act: OperatorCommand) -> bool:
        """Forbid motion from the moment on at which a halt is asked for; returns whether that was done."""
        if act.name not in HALTS or self._logbook.knows(act.key) or self._halts.wish is not None:
            return False
        try:
            # Only what would be allowed is wished: a pause of a session that waits would forbid the motion
            # that somebody confirms next.
            self.require(act)
        except SessionError:
            return False
        self._halts.wish = HALTS[act.name]
        return True

    async def _conduct(self) -> None:
        while not self._ended:
            if self._failure is not None:
                raise self._failure
            # Taken before the step: what changes while it is done is a change that has not been looked at.
            version = self.version
            # A halt that is not on record yet keeps everything back, whatever the ledger says.
            if self.situation.busy and not self._pending.due:
                await self.perform()
            if not self._ended and self.version == version:
                await self._logbook.changed(version)


def is_interruption(error: Exception) -> bool:
    """Whether devices have to be opened anew: the link, nonsense on it, or a driver that failed."""
    if isinstance(error, NotInitialisedError):
        return True
    spoken = MeasurementFailedError | DeviceRefusedError | ConfigurationError
    return isinstance(error, DriverError) and not isinstance(error, spoken)
