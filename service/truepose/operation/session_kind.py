"""What tells one kind of session from another, as far as the desk is concerned."""

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

from truepose.domain.errors import TrueposeError
from truepose.sequencing.engine.acts import Act
from truepose.sequencing.engine.runner import SessionRunner
from truepose.storage.errors import NotFoundError
from truepose.storage.measurement.ledger import SessionLedger
from truepose.storage.records import SessionRecord, SessionSetup

R = TypeVar("R", bound=SessionRunner[Any])


class SessionKind(ABC, Generic[R]):
    """What the desk asks of the sessions of one kind."""

    roles: frozenset[str]  # of the sessions of this kind
    called: str  # one of them, in a sentence

    def owns(self, record: SessionRecord) -> bool:
        """Whether a session is of this kind."""
        return record.role in self.roles

    @abstractmethod
    async def get(self, session_id: int) -> SessionRecord:
        """Return a session of this kind; raises NotFoundError, or what says that it is of another."""

    def of_another_kind(self, record: SessionRecord) -> TrueposeError:
        """Return what is raised of a session of another kind."""
        return NotFoundError(self.called, record.id)

    @abstractmethod
    def require_startable(self, record: SessionRecord, act: Act) -> None:
        """Raise NotNowError where this act does not take up a session that nobody runs."""

    @abstractmethod
    async def runner(self, record: SessionRecord, setup: SessionSetup, ledger: SessionLedger) -> R:
        """Return what runs a session, from the lines of its ledger; nothing moves yet."""

    @abstractmethod
    async def recover(self, record: SessionRecord) -> None:
        """Have a session that an earlier service left under way await a person; nothing moves."""

    async def begun(self, session_id: int, runner: R) -> None:
        """Wait for what a run does of itself before anybody acts."""

    async def prepare(self, session_id: int, act: Act) -> Act:
        """Return an act with what it rests on that the session itself does not know."""
        return act

    async def follow(self, session_id: int) -> None:
        """Do what follows a session that has finished."""

    async def leave(self, record: SessionRecord) -> None:
        """Put on record that the service ends while a session is under way."""
