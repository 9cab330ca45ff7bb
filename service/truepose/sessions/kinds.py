"""What tells one kind of session from another, as far as the desk is concerned."""

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.contacts import ContactPlan
from truepose.domain.errors import TrueposeError
from truepose.domain.session import SessionPlan
from truepose.sessions.engine.commands import OperatorCommand
from truepose.sessions.engine.runner import SessionRunner
from truepose.storage.errors import NotFoundError
from truepose.storage.ledger.entries import SessionLedger
from truepose.storage.records import SessionRecord, SessionSetup

R = TypeVar("R", bound=SessionRunner[Any])


class SessionKind(ABC, Generic[R]):
    """What the desk asks of the sessions of one kind."""

    roles: frozenset[str]  # of the sessions of this kind
    called: str  # one of them, in a sentence
    no_tracker: str  # key of why nothing of a tracker can be asked of them
    by_calibrator = False  # its lengths count from the ballbar's calibrator, not from certified nests
    shown_on_tablet = False  # whoever follows one under way stands in the cell, with the tablet

    def owns(self, record: SessionRecord) -> bool:
        """Whether a session is of this kind."""
        return record.role in self.roles

    @abstractmethod
    async def get(self, session_id: int) -> SessionRecord:
        """Return a session of this kind; raises NotFoundError, or what says that it is of another."""

    @abstractmethod
    async def stored_plan(self, session_id: int) -> SessionPlan | BallbarPlan | ContactPlan:
        """Return what a session of this kind does; raises NotFoundError."""

    def of_another_kind(self, record: SessionRecord) -> TrueposeError:
        """Return what is raised of a session of another kind."""
        return NotFoundError(self.called, record.id)

    @abstractmethod
    def require_startable(self, record: SessionRecord, act: OperatorCommand) -> None:
        """Raise NotNowError where this act does not take up a session that nobody runs."""

    @abstractmethod
    async def runner(self, record: SessionRecord, setup: SessionSetup, ledger: SessionLedger) -> R:
        """Return what runs a session, from the lines of its ledger; nothing moves yet."""

    @abstractmethod
    async def recover(self, record: SessionRecord) -> None:
        """Have a session that an earlier service left under way await a person; nothing moves."""

    async def begun(self, session_id: int, runner: R) -> None:
        """Wait for what a run does of itself before anybody acts."""

    async def prepare(self, session_id: int, act: OperatorCommand) -> OperatorCommand:
        """Return an act with what it rests on that the session itself does not know."""
        return act

    async def admit(self, session_id: int, act: OperatorCommand) -> OperatorCommand:
        """Return an act that lets the arm of another kind's session move, with what this kind adds to it.

        Raises NotNowError or ReasonMissingError where something of this kind is in the way.
        """
        return act

    async def follow(self, session_id: int) -> None:
        """Do what follows a session that has finished."""

    async def leave(self, record: SessionRecord) -> None:
        """Put on record that the service ends while a session is under way."""
