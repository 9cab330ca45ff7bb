"""Sessions of one kind behind the desk; of those that nobody stands beside, all that they share."""

from typing import Any, Final, TypeVar, cast

from truepose.domain.ledger import Control
from truepose.domain.session import SessionState
from truepose.messages.message import Text, message
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.engine.runner import SessionRunner
from truepose.sessions.engine.states import after_restart, words
from truepose.sessions.errors import NotNowError
from truepose.sessions.followers import change
from truepose.sessions.kinds import SessionKind
from truepose.sessions.service import SessionService
from truepose.storage.records import SessionRecord

R = TypeVar("R", bound=SessionRunner[Any])
_TAKES_UP: Final = {
    SessionState.PLANNED: CommandName.START,
    SessionState.AWAITING_CONFIRMATION: CommandName.CONFIRM,
}
_LETS_ARM_MOVE: Final = frozenset({CommandName.CONFIRM, CommandName.RESUME})
_RESTARTED: Final = message("session.service.restarted")
_STOPPED: Final = message("session.service.stopped")


class SessionKindService(SessionKind[R]):
    """Sessions of one kind, started and acted on by the desk."""

    def __init__(self, desk: SessionService) -> None:
        self.desk = desk
        desk.serve(self)

    def running(self, session_id: int) -> R | None:
        """Return what runs a session of this kind; None where nobody does."""
        found = self.desk.under_way(session_id)
        return cast(R, found.runner) if found is not None and found.kind is self else None

    async def get(self, session_id: int) -> SessionRecord:
        """Return a session of this kind; raises NotFoundError, or what says that it is of another."""
        record = await self.desk.sessions.get(session_id)
        if not self.owns(record):
            raise self.of_another_kind(record)
        return record


class UnattendedSessionService(SessionKindService[R]):
    """Sessions that nobody stands beside: started, they ask; after a restart they wait for an answer."""

    def require_startable(self, record: SessionRecord, act: OperatorCommand) -> None:
        """Raise NotNowError unless a planned one is started, or confirmed what an earlier service left."""
        if _TAKES_UP.get(record.state) is act.name:
            return
        state = words(record.state)
        if act.name is CommandName.START:
            raise NotNowError(message("session.refused.session_only_planned", session=record.id, state=state))
        raise NotNowError(message("session.refused.not_under_way", session=record.id, state=state))

    async def prepare(self, session_id: int, act: OperatorCommand) -> OperatorCommand:
        """Return an act with why the ballbar counts as off; raises NotNowError, ReasonMissingError."""
        return await self.desk.admitted(self, session_id, act) if act.name in _LETS_ARM_MOVE else act

    async def begun(self, session_id: int, runner: R) -> None:
        """Wait for the question; raises RecordRefusedError where it cannot be put on record."""
        while self.running(session_id) is runner:
            # Taken before looking, so that no change falls between the look and the wait.
            news, version, now = self.desk.watching.news, runner.version, runner.moment
            # The question comes first, the state that it puts the session in once the journal has it.
            if now.prompt is not None and now.state is not SessionState.PLANNED:
                return
            # A question that is not on record asks nobody: the start is refused in the storage's own words,
            # and the devices are given back.
            if runner.cause_of_trouble is not None:
                raise type(runner.cause_of_trouble)(
                    message("session.not_started", session=session_id, sentence=now.trouble or "")
                )
            await change(news, runner, version)

    async def recover(self, record: SessionRecord) -> None:
        """Have a session await a person's confirmation, which takes it up."""
        await self._enter_after_restart(record, _RESTARTED)

    async def leave(self, record: SessionRecord) -> None:
        """Have a session await a person's confirmation of the next service."""
        await self._enter_after_restart(record, _STOPPED)

    async def _enter_after_restart(self, record: SessionRecord, reason: Text) -> None:
        state = after_restart(record.state)
        if state is not record.state:
            await self.desk.enter(record.id, state, reason, control=Control.RESTARTED)
