"""A session with somebody who looks after it: what a person does when it stands, and nothing else."""

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from truepose.demo.cell.client import ServiceClient
from truepose.demo.errors import SessionHaltedError

_LOOK_S: Final = 0.05
_MOST_RESUMED: Final = 50  # far more than a night's faults; a session that needs more will never end
_FAILED: Final = frozenset({"aborted", "failed"})


@dataclass(slots=True)
class Attended:
    """What somebody saw who looked after a session."""

    reasons: list[str] = field(default_factory=list)  # why it stood, in its own words
    session: dict[str, Any] = field(default_factory=dict)  # as the service showed it last

    @property
    def finished(self) -> bool:
        """Whether everything planned was measured or left out with a reason."""
        return self.session.get("state") == "finished"


async def attend(
    client: ServiceClient, session_id: int, enough: Callable[[int], bool] = lambda measured: False
) -> Attended:
    """Bring a session to its end, or until `enough` configurations are measured.

    Raises
    ------
    SessionHaltedError
        It failed, or stands again and again.
    """
    seen = Attended()
    while True:
        seen.session = await client.get(f"/sessions/{session_id}")
        if seen.finished or enough(int(seen.session["measured"])):
            return seen
        await _help(client, seen)
        await asyncio.sleep(_LOOK_S)


async def _help(client: ServiceClient, seen: Attended) -> None:
    session_id, state = int(seen.session["id"]), str(seen.session["state"])
    if state in _FAILED or len(seen.reasons) > _MOST_RESUMED:
        raise SessionHaltedError(f"Session {session_id} is {state}: {seen.session['reason']}")
    if state in {"paused", "awaiting_confirmation"}:
        seen.reasons.append(str(seen.session["reason"]))
        await (client.resume if state == "paused" else client.confirm)(session_id)
