"""Runs a session of any kind: does the present step, takes what persons ask, keeps every line.

- Nothing is remembered but the ledger: the present step follows from it, also after a restart.
- A halt holds from the moment at which it is asked for; an act with a key is done once.
- A line that the ledger refuses is tried again, and nothing moves meanwhile; a halt holds all the same.
"""

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Coroutine
from dataclasses import replace
from typing import Any, Final, Generic, Protocol, TypeVar

from truepose.domain.errors import RecordRefusedError
from truepose.domain.measurement.ledger import BALLBAR_OFF, EntryKind
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.acts import HALTS, LETS_MOVE, Act, ActName, ActOutcome
from truepose.sequencing.engine.halting.halts import Halts
from truepose.sequencing.engine.halting.pending import PendingHalts
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.engine.moment import Moment
from truepose.sequencing.engine.onlookers import Onlooker, looked_on
from truepose.sequencing.engine.states import has_ended, words
from truepose.sequencing.errors import NotNowError, SequencingError
from truepose_drivers.api import GuardsMotion

_JUST_NOW_S: Final = 3.0  # a page says after two that nobody has heard


class Situation(Protocol):
    """What every kind of session says of itself."""

    @property
    def busy(self) -> bool:
        """Whether the present step is done by the program, as soon as nothing forbids it."""
        ...

    @property
    def question(self) -> str | None:
        """What a person is asked to look at."""
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
        self._pending = PendingHalts(logbook, halts, self.act, self)

    @property
    def situation(self) -> S:
        """Where the session stands, as the ledger has it."""
        return self._logbook.situation

    @property
    def state(self) -> SessionState:
        """The state that the session is in, as the ledger has it."""
        return self._logbook.state

    @property
    def question(self) -> str | None:
        """What a person is asked to look at, or why the session waits; None where neither is."""
        return self.trouble or self.situation.question

    @property
    def prompt_id(self) -> int | None:
        """Number of the line that asks it: no other question has it; None where nothing is asked."""
        return None if self.question is None else self._logbook.prompt_id

    @property
    def trouble(self) -> str | None:
        """What a person is told while lines are refused; nothing moves meanwhile."""
        return self._logbook.trouble

    @property
    def cause_of_trouble(self) -> RecordRefusedError | None:
        """Why lines are refused; None while they are taken."""
        return self._logbook.cause_of_trouble

    @property
    def moment(self) -> Moment:
        """What the session says of itself now; nothing is awaited, so that all of it is of one moment."""
        return Moment(self.state, self._logbook.record.reason, self.question, self.prompt_id, self.trouble)

    @property
    def version(self) -> int:
        """Number of changes so far."""
        return self._logbook.version

    async def changed(self, after: int) -> int:
        """Return the version once it is above `after`."""
        return await self._logbook.changed(after)

    # what a kind of session does in its own way; who calls `do`, `settle` and `hold` holds `changing`

    @abstractmethod
    def require(self, act: Act) -> None:
        """Raise PersonMissingError, WatchingTabletError or NotNowError where an act is not allowed now."""

    def lets_move(self, act: Act) -> bool:
        """Return whether the arm may move after an act."""
        return act.name in LETS_MOVE

    async def prepare(self, act: Act) -> None:
        """Wait for what an act rests on, before it counts."""

    @abstractmethod
    async def do(self, act: Act) -> ActOutcome:
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
    async def hold(self, reason: str) -> None:
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

    async def close(self) -> None:
        """Let go of what was followed."""

    # the same for every kind

    async def act(self, act: Act) -> ActOutcome:
        """Do what a person asks, once for each key; the outcome is on disk when this returns.

        Raises NotNowError, PersonMissingError, ReasonMissingError and WatchingTabletError; nothing was done
        then. Where it cannot be kept RecordRefusedError: a halt of a running session holds and is kept later.
        """
        wished = self._wish_at_once(act)
        was_running = self._runs
        try:
            await self.prepare(act)
            async with self._logbook.changing:
                await self._logbook.open()
                earlier = await self._logbook.earlier_outcome(act.key)
                if earlier is not None:
                    return earlier
                self.require(act)
                self._require_prompt(act)
                self._require_just_pressed(act)
                if act.name is ActName.CONFIRM and was_running != self._runs:
                    raise NotNowError(  # what was confirmed is not what is asked now
                        f"The session became {words(self.state)} meanwhile; look at the cell, confirm anew."
                    )
                await self._note_ballbar(act)
                return self._logbook.keep_outcome(act.key, await self.do(act))
        except RecordRefusedError:
            if wished:
                self._pending.owe(act)
            raise
        except SequencingError:
            if wished and self._halts.wish is HALTS[act.name]:
                self._halts.wish = None
            raise
        except Exception as error:
            if wished:  # nobody will enter that state any more, and the arm must not go on either
                self._failure = error
            raise
        finally:
            self._logbook.tell()

    async def ask(self, act: Act) -> ActOutcome:
        """As `act`; a halt that holds although it cannot be kept yet is answered all the same."""
        try:
            return await self.act(act)
        except RecordRefusedError:
            if self._pending.owed is not act:
                raise
            return ActOutcome(self._halts.not_on_record(act), None)

    async def run(self) -> SessionState:
        """Run to the end and return the state it ended in; first a person has to let it.

        Raises what the ledger raises. Every fault of the devices becomes a state with a sentence; so does a
        mistake of the program, which ends this run.
        """
        async with looked_on(self.onlookers()):
            return await self._run()

    async def _run(self) -> SessionState:
        loops: list[asyncio.Task[None]] = []
        try:
            await self.begin()
            loops += [asyncio.create_task(loop) for loop in self._loops()]
            await asyncio.wait(loops, return_when=asyncio.FIRST_COMPLETED)
        except Exception as error:
            await self.note_failure(error)
            raise
        finally:
            for task in loops:
                task.cancel()
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

    def _require_prompt(self, act: Act) -> None:
        """Raise NotNowError where a person lets the session go on who saw another question."""
        if act.name in LETS_MOVE and act.prompt_id not in {None, self.prompt_id}:
            raise NotNowError(
                f"Prompt {act.prompt_id} is not what is asked now; read the question, look at the cell, "
                "confirm anew."
            )

    def _require_just_pressed(self, act: Act) -> None:
        """Raise NotNowError where the person pressed it who looked at the cell a while ago."""
        if self.lets_move(act) and not abs(act.under_way_s) <= _JUST_NOW_S:
            raise NotNowError("It was not pressed just now; look at the cell and confirm anew.")

    async def _note_ballbar(self, act: Act) -> None:
        """Put on record why the ballbar of an earlier session counts as off, before the arm is let move."""
        if act.ballbar_off:
            of_it = replace(act, key=None)  # the key is that of the line which the act itself makes
            await self._logbook.append(EntryKind.NOTED, BALLBAR_OFF, of_it, text=act.ballbar_off)

    def _wish_at_once(self, act: Act) -> bool:
        """Forbid motion from the moment on at which a halt is asked for; returns whether that was done."""
        if act.name not in HALTS or self._logbook.knows(act.key) or self._halts.wish is not None:
            return False
        try:
            self.require(act)
        except SequencingError:
            return False
        self._halts.wish = HALTS[act.name]
        return True

    async def _conduct(self) -> None:
        while not self._ended:
            if self._failure is not None:
                raise self._failure
            version = self.version
            if self.situation.busy and not self._pending.due:
                await self.perform()
            if not self._ended and self.version == version:
                await self._logbook.changed(version)
