"""What tells one kind of session from another, as far as the desk is concerned."""

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

from truepose.operation.session_ledger import SessionLedger
from truepose.sequencing.engine.acts import Act
from truepose.sequencing.engine.runner import SessionRunner
from truepose.storage.records import ActAnswer, RequestKey, SessionRecord, SessionSetup

if TYPE_CHECKING:
    from truepose.operation.sessions import SessionDesk

R = TypeVar("R", bound=SessionRunner[Any])


class SessionKind(ABC, Generic[R]):
    """Sessions of one kind behind the desk."""

    def __init__(self, desk: "SessionDesk") -> None:
        self.desk = desk
        desk.serve(self)

    def running(self, session_id: int) -> R | None:
        """Return what runs a session of this kind; None where nobody does."""
        found = self.desk.under_way(session_id)
        return cast(R, found.runner) if found is not None and found.kind is self else None

    async def act(self, session_id: int, act: Act, key: RequestKey | None = None) -> ActAnswer:
        """Do what a person asks of a session of this kind; see `SessionDesk.act`."""
        return await self.desk.act(self, session_id, act, key)

    @abstractmethod
    def owns(self, record: SessionRecord) -> bool:
        """Whether a session is of this kind."""

    @abstractmethod
    async def get(self, session_id: int) -> SessionRecord:
        """Return a session of this kind; raises NotFoundError, or what says that it is of another."""

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

    async def prepare(self, session_id: int, act: Act) -> None:
        """See to what an act rests on that the session itself does not know."""

    async def follow(self, session_id: int) -> None:
        """Do what follows a session that has finished."""

    async def leave(self, record: SessionRecord) -> None:
        """Put on record that the service ends while a session is under way."""
