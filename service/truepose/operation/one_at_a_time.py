"""One session has the robot at a time, whatever its kind."""

from typing import Final

from truepose.domain.session import SessionState
from truepose.operation.errors import DeviceInUseError
from truepose.sequencing.engine.states import has_ended, words
from truepose.storage.measurement.sessions import SessionRepository

UNDER_WAY: Final = tuple(
    state for state in SessionState if state is not SessionState.PLANNED and not has_ended(state)
)


async def refuse_beside_another(sessions: SessionRepository, session_id: int) -> None:
    """Raise DeviceInUseError where another session than this one is under way."""
    for other in await sessions.in_state(*UNDER_WAY):
        if other.id != session_id:
            raise DeviceInUseError(
                f"Session {other.id} is {words(other.state)}; one session runs at a time, end it first."
            )
