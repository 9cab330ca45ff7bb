"""Sessions whose arm goes from configuration to configuration while nobody is in the cell."""

from abc import abstractmethod
from dataclasses import dataclass, replace
from typing import Final, Protocol, TypeVar

from truepose.domain.errors import text_of
from truepose.domain.session import Progress, SessionState
from truepose.messages.message import Text, message, together
from truepose.sessions.engine.arm import Permission
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.progress import FINISHED
from truepose.sessions.engine.prompts import CELL_CLEAR, Prompt, require_person
from truepose.sessions.engine.runner import SessionRunner, Situation
from truepose.sessions.engine.states import ASKS, require_transition, words
from truepose.sessions.errors import NotNowError


class UnattendedSituation(Situation, Protocol):
    """What such a session says of itself besides."""

    @property
    def step(self) -> object | None:
        """What is due next; None where nothing is left."""
        ...

    @property
    def progress(self) -> Progress:
        """How far the session is."""
        ...


S = TypeVar("S", bound=UnattendedSituation)

_WAITS_IN: Final = {
    CommandName.CONFIRM: SessionState.AWAITING_CONFIRMATION,
    CommandName.RESUME: SessionState.PAUSED,
}


class UnattendedRunner(SessionRunner[S]):
    """A session that moves while nobody is in the cell: every confirmation is that the cell is clear."""

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

    def _asked_now(self) -> CommandOutcome:
        asked = self.prompt
        return CommandOutcome("", None) if asked is None else CommandOutcome(asked.message, asked.id)

    def _permission(self, _: float) -> Permission:
        # Wishes count before they are on record; the state alone would let one more motion pass.
        return Permission(self.state, self._halts.wish is not None, self.situation.question, self.trouble)

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
            error.add_note(f"Nor could that be kept ({type(second).__name__}): {second}")
            # In memory at least: whoever looks must not be shown a session that runs.
            self._logbook.record.enter(SessionState.FAILED, reason)


@dataclass(frozen=True, slots=True)
class RunsByItself:
    """Where a session stands, as far as a person is concerned."""

    state: SessionState
    reason: Text  # why this state was entered; of a person who is waited for: the question

    @property
    def busy(self) -> bool:
        """Whether the present step is done, as soon as nothing forbids it."""
        return self.state is SessionState.RUNNING

    @property
    def question(self) -> Text | None:
        """What a person is asked to confirm, or why the session waits."""
        return self.reason if self.state in ASKS else None
