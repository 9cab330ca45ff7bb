"""One kind of session as it travels: what the resource `/sessions` asks of each."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from fastapi import Depends, Request

from truepose.web.api.sessions.situations import SituationReply
from truepose.web.api.spaces import StopState
from truepose.web.context import Context
from truepose.web.resources import Later, OptionalKey, Sender
from truepose.web.schemas import Reply

if TYPE_CHECKING:
    from truepose.reports.plan_3d import Place


@dataclass(frozen=True, slots=True)
class Planning:
    """What came with a request for a plan, beside its body."""

    request: Request
    key: OptionalKey
    later: Later  # the client would rather be told of a job than wait
    sender: Sender


PlanningRequest = Annotated[Planning, Depends()]


@dataclass(frozen=True, slots=True)
class Planned:
    """The number of a session that was planned, or of the job that will plan it."""

    number: int
    by_job: bool = False


class KindOfSession(ABC):
    """How sessions of one kind are planned, and what those who follow them are sent."""

    roles: ClassVar[frozenset[str]]  # of the sessions of this kind
    called: ClassVar[str]  # as a request for a plan names it
    tablet_page: ClassVar[str] = "tracker_session.html"  # for who stands at the robot

    @abstractmethod
    async def plan(self, here: Context, wanted: Any, planning: Planning) -> Planned:
        """Plan a session, or have a job do it; nothing moves."""

    @abstractmethod
    async def situation(self, here: Context, id: int) -> SituationReply:
        """Return where a session stands."""

    @abstractmethod
    def sample(self, seen: Any) -> dict[str, object]:
        """Return what its instrument sees, as it is streamed."""

    @abstractmethod
    async def planned_steps(self, here: Context, id: int) -> Reply:
        """Return what a session does, in order."""

    @abstractmethod
    async def places(self, here: Context, id: int) -> "tuple[list[Place], dict[int, StopState]]":
        """Return where the plan sends the arm, and what became of the stops of which nothing is to come."""

    @abstractmethod
    async def scene(self, here: Context, id: int) -> Reply:
        """Return what to draw of a session."""
