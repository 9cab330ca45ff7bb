"""Sessions whose arm goes from configuration to configuration while nobody is in the cell."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Protocol, TypeVar

from truepose.domain.contacts import ContactTaken
from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind
from truepose.domain.people import tidy_name
from truepose.domain.robot import JointRange
from truepose.domain.session import Progress, SessionState
from truepose.messages.message import Text, message, together
from truepose.sessions.engine.arm import Arm, ArmCell, Permission
from truepose.sessions.engine.commands import HALTS, CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.halts import Halts
from truepose.sessions.engine.interlocks import end_of_motion
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.progress import FINISHED
from truepose.sessions.engine.prompts import CELL_CLEAR, Prompt, require_person
from truepose.sessions.engine.runner import SessionRunner, is_interruption
from truepose.sessions.engine.states import ASKS, require_transition, words
from truepose.sessions.engine.ways import KnownWays
from truepose.sessions.errors import MotionForbiddenError, NotNowError, SessionError
from truepose_drivers.errors import DriverError


class UnattendedStep(Protocol):
    """What a session does between two checkpoints."""

    @property
    def id(self) -> str:
        """The name by which the ledger knows it."""
        ...

    @property
    def title(self) -> Text:
        """What goes on, as the operator reads it."""
        ...


@dataclass(frozen=True, slots=True)
class RunsByItself(ABC):
    """Where a session stands, as far as a person is concerned."""

    state: SessionState
    reason: Text  # why this state was entered; of a person who is waited for: the question
    step: object | None  # what is due next; None: nothing is left to do
    progress: Progress

    @property
    def busy(self) -> bool:
        """Whether the present step is done, as soon as nothing forbids it."""
        return self.state is SessionState.RUNNING

    @property
    def question(self) -> Text | None:
        """What a person is asked to confirm, or why the session waits."""
        return self.reason if self.state in ASKS else None

    @property
    @abstractmethod
    def leads_to(self) -> tuple[int, ...]:
        """Configurations to which the arm may go once the question is answered."""


@dataclass(frozen=True, slots=True)
class Line:
    """What is put on record at the end of a step."""

    kind: EntryKind
    step_id: str = ""
    text: Text = ""
    entered: SessionState | None = None
    contact: ContactTaken | None = None  # what gauges read


def awaits_person(what: Text, step_id: str = "") -> Line:
    """Return the line by which a person is told something, and confirms that the cell is clear."""
    state = SessionState.AWAITING_CONFIRMATION
    return Line(EntryKind.CONTROL, step_id, together(what, CELL_CLEAR), state)


S = TypeVar("S", bound=RunsByItself)

_WAITS_IN: Final = {
    CommandName.CONFIRM: SessionState.AWAITING_CONFIRMATION,
    CommandName.RESUME: SessionState.PAUSED,
}


class UnattendedRunner(SessionRunner[S]):
    """A session that moves while nobody is in the cell: every confirmation is that the cell is clear."""

    progress_on_each_line = False  # at the end of a step; else only where the session waits for a person

    def __init__(
        self,
        logbook: Logbook[S],
        cell: ArmCell,
        limits: tuple[JointRange, ...],
        tolerance_rad: float,
        effects: Mapping[SessionState, Text],
    ) -> None:
        """Run what `logbook` keeps; a halt that takes effect is on record by what `effects` say."""
        robot = cell.robot_controller
        super().__init__(logbook, Halts(logbook, lambda: end_of_motion(robot), effects), robot)
        self._ways = KnownWays(cell.look_at_ways)
        permission = self._permission
        self._arm = Arm(robot, cell.clock, cell.robot, limits, tolerance_rad, permission, self._ways)

    @property
    @abstractmethod
    def has_asked(self) -> bool:
        """Whether this run has asked a person: before, nobody lets the session go on."""

    @property
    def prompt(self) -> Prompt | None:
        """What a person is asked to confirm; None before this run has asked."""
        return super().prompt if self.has_asked else None

    @property
    def progress(self) -> Progress:
        """How far the session is."""
        return self.situation.progress

    @property
    def finishes_because(self) -> Text:
        """Why the session ends where nothing is left to do."""
        return message("session.all_measured")

    def require(self, act: OperatorCommand) -> None:
        """Raise NotNowError, PersonMissingError where an act is not allowed now."""
        if act.name is CommandName.START:
            require_person(act.person)
            if self.state is not SessionState.AWAITING_CONFIRMATION:
                raise NotNowError(message("session.refused.only_planned", state=words(self.state)))
        # A stop after a pause is more: it wants a confirmation instead of a resumption.
        elif act.name is CommandName.STOP and self.state is SessionState.PAUSING:
            return
        elif act.name in {CommandName.PAUSE, CommandName.STOP}:
            require_transition(self.state, SessionState.PAUSING)
        elif act.name is CommandName.ABORT:
            if self._ended or self.state is SessionState.ABORTING:
                raise NotNowError(message("session.refused.already", state=words(self.state)))
        else:
            require_person(act.person)
            # After a restart the state may be that of an earlier run. Its question counts no more: the cell
            # has been left alone since.
            if self.state is not _WAITS_IN.get(act.name) or not self.has_asked:
                raise NotNowError(
                    message("session.refused.nothing_to_do", state=words(self.state), act=act.name)
                )

    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError."""
        if act.name in HALTS:
            return await self._halts.halt(act)
        if act.name is CommandName.START:
            return self._asked_now()
        return CommandOutcome(message("session.done.confirmed"), await self._go_on(act))

    async def _go_on(self, act: OperatorCommand) -> int:
        """Have the session go on as a person says; returns the number of the line."""
        name, asked = tidy_name(act.person), self._logbook.record.reason
        number = await self._logbook.enter(SessionState.RUNNING, message("session.went_on", person=name), act)
        # Only once the line is on disk: a refused confirmation must not take back a halt.
        self._halts.forget()
        self._ways.confirm(asked)
        # A person had the cell: where the arm stands now has been confirmed, and its last directions are
        # unknown.
        self._arm.forget()
        return number

    def _asked_now(self) -> CommandOutcome:
        asked = self.prompt
        return CommandOutcome("", None) if asked is None else CommandOutcome(asked.message, asked.id)

    def _permission(self, _: float) -> Permission:
        # Wishes count before they are on record; the state alone would let one more motion pass.
        return Permission(self.state, self._halts.wish is not None, self.situation.question, self.trouble)

    # what the run does; a kind of session says what its steps are

    async def perform(self) -> None:
        """Do the present step; after a fault the ledger says what is to be done about it."""
        if self._halts.wish is not None:
            return
        if self.situation.step is None:
            await self._logbook.keep(self.settle)
        else:
            await self.perform_step()

    @abstractmethod
    async def perform_step(self) -> None:
        """Do the present step, or ask what comes before it."""

    @abstractmethod
    async def operate(self, step: Any) -> Sequence[Line]:
        """Do a step; returns what is put on record at its end. Raises what devices and checks raise."""

    @abstractmethod
    async def let_go(self) -> None:
        """Close the links: the step begins again with the opening of the devices."""

    @abstractmethod
    def lines_after(self, error: SessionError | DriverError, step: Any) -> Sequence[Line]:
        """Return what is put on record after a fault; raises what is no fault of a cell."""

    async def _do(self, step: UnattendedStep) -> None:
        self._halts.moving = True
        try:
            lines = deque(await self._attempt(step))
        finally:
            self._halts.moving = False
        await self._logbook.keep(lambda: self._conclude(lines))

    async def _attempt(self, step: UnattendedStep) -> Sequence[Line]:
        progress = replace(self.progress, doing=step.title)
        await self._logbook.write(EntryKind.BEGUN, step.id, text=step.title, progress=progress)
        try:
            return await self.operate(step)
        except (SessionError, DriverError) as error:
            if isinstance(error, MotionForbiddenError) and self._halts.wish is not None:
                return ()  # asked for between two looks
            if is_interruption(error):
                await self.let_go()
            return self.lines_after(error, step)

    async def _conclude(self, lines: deque[Line]) -> None:
        """Put on record how a step ended, once; a halt that was asked for meanwhile takes effect."""
        ends = self._halts.wish is SessionState.ABORTED
        while lines:
            waits = lines[0].entered is not None
            # A question to a person who has ended the session would keep it from ending.
            if not (waits and ends):
                await self._put_on_record(lines[0])
            if waits and not ends:
                self._halts.wish = None  # it waits for a person, as was wished
            # After the line is kept: where one is refused this is done again, from the line that is not kept
            # yet.
            lines.popleft()
        await self.follow_step()

    async def _put_on_record(self, line: Line) -> None:
        said: dict[str, Any] = {"text": line.text, "entered": line.entered, "contact": line.contact}
        progress = self.progress if self.progress_on_each_line or line.entered is not None else None
        await self._logbook.append(line.kind, line.step_id, progress=progress, **said)

    async def hold(self, reason: Text) -> None:
        """Have the session wait for a person: something is not as it was left."""
        if self.state in {SessionState.RUNNING, SessionState.PAUSING}:
            await self._logbook.enter(SessionState.AWAITING_CONFIRMATION, together(reason, CELL_CLEAR))

    async def follow_step(self) -> None:
        """Have a halt that was asked for during a step take effect, then settle."""
        if self.state in {SessionState.PAUSING, SessionState.ABORTING}:
            await self._halts.take_effect()
        await self.settle()

    async def settle(self) -> None:
        """End the session where nothing is left to do."""
        if self.situation.busy and self._halts.wish is None and self.situation.step is None:
            progress = replace(self.progress, doing=FINISHED)
            await self._logbook.enter(SessionState.FINISHED, self.finishes_because, progress=progress)

    async def note_failure(self, error: Exception) -> None:
        """End the session as failed."""
        reason = message("session.program_failed", kind=type(error).__name__, why=text_of(error))

        async def fail() -> None:
            if not self._ended:
                await self._logbook.enter(SessionState.FAILED, reason)

        try:
            await self._logbook.keep(fail)
        except Exception as second:  # the run ends with the first one: the log must not name another instead
            error.add_note(f"The error could not be saved either ({type(second).__name__}): {second}")
            # In memory at least: whoever looks must not be shown a session that runs.
            self._logbook.record.enter(SessionState.FAILED, reason)
