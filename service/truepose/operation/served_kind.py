"""Sessions of one kind behind the desk; of those that nobody stands beside, all that they share."""

from typing import Any, Final, TypeVar, cast

from truepose.domain.measurement.ledger import Control
from truepose.domain.measurement.session import SessionState
from truepose.operation.followers import change
from truepose.operation.session_kind import SessionKind
from truepose.operation.sessions import SessionDesk
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.engine.runner import SessionRunner
from truepose.sequencing.engine.states import after_restart, words
from truepose.sequencing.errors import NotNowError
from truepose.storage.records import ActAnswer, RequestKey, SessionRecord

R = TypeVar("R", bound=SessionRunner[Any])
_TAKES_UP: Final = {
    SessionState.PLANNED: ActName.START,
    SessionState.AWAITING_CONFIRMATION: ActName.CONFIRM,
}
_LETS_ARM_MOVE: Final = frozenset({ActName.CONFIRM, ActName.RESUME})
_RESTARTED: Final = "The service was restarted during the session; look at the cell, then confirm."
_STOPPED: Final = "The service was stopped during the session; look at the cell, then confirm."


class ServedKind(SessionKind[R]):
    """Sessions of one kind, started and acted on by the desk."""

    def __init__(self, desk: SessionDesk) -> None:
        self.desk = desk
        desk.serve(self)

    def running(self, session_id: int) -> R | None:
        """Return what runs a session of this kind; None where nobody does."""
        found = self.desk.under_way(session_id)
        return cast(R, found.runner) if found is not None and found.kind is self else None

    async def act(self, session_id: int, act: Act, key: RequestKey | None = None) -> ActAnswer:
        """Do what a person asks of a session of this kind; see `SessionDesk.act`."""
        return await self.desk.act(self, session_id, act, key)

    async def get(self, session_id: int) -> SessionRecord:
        """Return a session of this kind; raises NotFoundError, or what says that it is of another."""
        record = await self.desk.sessions.get(session_id)
        if not self.owns(record):
            raise self.of_another_kind(record)
        return record


class AskedSessionKind(ServedKind[R]):
    """Sessions that nobody stands beside: started, they ask; after a restart they wait for an answer."""

    async def start(self, session_id: int) -> str:
        """Start a planned session and return what a person is asked before anything moves.

        Raises NotFoundError, NotNowError, DeviceInUseError, MissingDeviceError, PlanRefusedError,
        CellChangedError.
        """
        await self.desk.present.require_unchanged()
        async with self.desk.turn:
            record = await self.get(session_id)
            if record.state is not SessionState.PLANNED:
                raise NotNowError(
                    f"Session {session_id} is {words(record.state)}; only a planned one starts."
                )
            return (await self.desk.start(self, record)).runner.question or ""

    def require_startable(self, record: SessionRecord, act: Act) -> None:
        """Raise NotNowError unless a planned one is started, or confirmed what an earlier service left."""
        if _TAKES_UP.get(record.state) is not act.name:
            raise NotNowError(f"Session {record.id} is {words(record.state)}; nothing of it is under way.")

    async def prepare(self, session_id: int, act: Act) -> Act:
        """Return an act with why the ballbar counts as off; raises NotNowError, ReasonMissingError."""
        return await self.desk.judged_by_ballbar(session_id, act) if act.name in _LETS_ARM_MOVE else act

    async def begun(self, session_id: int, runner: R) -> None:
        """Wait for the question; raises RecordRefusedError where it cannot be put on record."""
        while self.running(session_id) is runner:
            news, version, now = self.desk.watching.news, runner.version, runner.moment
            # The question comes first, the state that it puts the session in once the journal has it.
            if now.question is not None and now.state is not SessionState.PLANNED:
                return
            if runner.cause_of_trouble is not None:
                raise type(runner.cause_of_trouble)(f"Session {session_id} was not started. {now.trouble}")
            await change(news, runner, version)

    async def recover(self, record: SessionRecord) -> None:
        """Have a session await a person's confirmation, which takes it up."""
        await self._enter_after_restart(record, _RESTARTED)

    async def leave(self, record: SessionRecord) -> None:
        """Have a session await a person's confirmation of the next service."""
        await self._enter_after_restart(record, _STOPPED)

    async def _enter_after_restart(self, record: SessionRecord, reason: str) -> None:
        state = after_restart(record.state)
        if state is not record.state:
            await self.desk.enter(record.id, state, reason, control=Control.RESTARTED)
