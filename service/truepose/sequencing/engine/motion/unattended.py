"""What the runs of sessions share whose arm goes from stop to stop while nobody is in the cell."""

from abc import abstractmethod
from dataclasses import replace
from typing import Final, Protocol, TypeVar

from truepose.domain.measurement.session import Progress, SessionState
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.engine.motion.arm import Permission
from truepose.sequencing.engine.prompts import CELL_CLEAR, require_person
from truepose.sequencing.engine.runner import SessionRunner, Situation
from truepose.sequencing.engine.states import require_transition, words
from truepose.sequencing.errors import NotNowError


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
    ActName.CONFIRM: SessionState.AWAITING_CONFIRMATION,
    ActName.RESUME: SessionState.PAUSED,
}


class UnattendedRunner(SessionRunner[S]):
    """A session that moves while nobody is in the cell: every confirmation is that the cell is clear."""

    @property
    @abstractmethod
    def has_asked(self) -> bool:
        """Whether this run has asked a person: before, nobody lets the session go on."""

    @property
    def question(self) -> str | None:
        """What a person is asked to confirm, or why the session waits; None before this run has asked."""
        return self.trouble or (self.situation.question if self.has_asked else None)

    @property
    def progress(self) -> Progress:
        """How far the session is."""
        return self.situation.progress

    @property
    def finishes_because(self) -> str:
        """Why the session ends where nothing is left to do."""
        return "Every configuration was measured or skipped."

    def require(self, act: Act) -> None:
        """Raise NotNowError, PersonMissingError where an act is not allowed now."""
        if act.name is ActName.START:
            require_person(act.person)
            if self.state is not SessionState.AWAITING_CONFIRMATION:
                raise NotNowError(f"The session is {words(self.state)}; only a planned one starts.")
        elif act.name is ActName.STOP and self.state is SessionState.PAUSING:
            return
        elif act.name in {ActName.PAUSE, ActName.STOP}:
            require_transition(self.state, SessionState.PAUSING)
        elif act.name is ActName.ABORT:
            if self._ended or self.state is SessionState.ABORTING:
                raise NotNowError(f"The session is {words(self.state)} already.")
        else:
            require_person(act.person)
            if self.state is not _WAITS_IN.get(act.name) or not self.has_asked:
                raise NotNowError(f"The session is {words(self.state)}; there is nothing to {act.name}.")

    def _permission(self, _: float) -> Permission:
        return Permission(self.state, self._halts.wish is not None, self.situation.question, self.trouble)

    async def hold(self, reason: str) -> None:
        """Have the session wait for a person: something is not as it was left."""
        if self.state in {SessionState.RUNNING, SessionState.PAUSING}:
            await self._logbook.enter(SessionState.AWAITING_CONFIRMATION, f"{reason} {CELL_CLEAR}")

    async def follow_step(self) -> None:
        """Have a halt that was asked for during a step take effect, then settle."""
        if self.state in {SessionState.PAUSING, SessionState.ABORTING}:
            await self._halts.take_effect()
        await self.settle()

    async def settle(self) -> None:
        """End the session where nothing is left to do."""
        if self.situation.busy and self._halts.wish is None and self.situation.step is None:
            progress = replace(self.progress, doing="finished")
            await self._logbook.enter(SessionState.FINISHED, self.finishes_because, progress=progress)

    async def note_failure(self, error: Exception) -> None:
        """End the session as failed."""
        reason = f"The program failed ({type(error).__name__}): {error}"

        async def fail() -> None:
            if not self._ended:
                await self._logbook.enter(SessionState.FAILED, reason)

        try:
            await self._logbook.keep(fail)
        except Exception as second:  # the run ends with the first one: the log must not name another instead
            error.add_note(f"Nor could that be kept ({type(second).__name__}): {second}")
            self._logbook.record.enter(SessionState.FAILED, reason)
