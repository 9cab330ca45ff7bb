"""The table of the kinds of sessions; a new one is a line here and what it names."""

from typing import Annotated, Final, TypeAlias

from pydantic import Discriminator, Tag

from truepose.storage.records import SessionRecord
from truepose.web.api.sessions.ballbar import BallbarKind
from truepose.web.api.sessions.ballbar_replies import BallbarSessionReply, SceneReply, StepsReply
from truepose.web.api.sessions.ballbar_requests import BallbarSessionRequest
from truepose.web.api.sessions.contact_schemas import ContactPlanReply, ContactSessionRequest
from truepose.web.api.sessions.guides import GuidedSceneReply, GuideReply
from truepose.web.api.sessions.kind import KindOfSession
from truepose.web.api.sessions.schemas import PlanReply, SessionRequest
from truepose.web.api.sessions.unattended import ContactKind, TrackerKind

_KINDS: Final[tuple[KindOfSession, ...]] = (TrackerKind(), ContactKind(), BallbarKind())


def _called(wanted: object) -> str:
    kind = wanted.get("kind", TrackerKind.called) if isinstance(wanted, dict) else TrackerKind.called
    return kind if isinstance(kind, str) else ""


AnySessionRequest: TypeAlias = Annotated[
    Annotated[SessionRequest, Tag(TrackerKind.called)]
    | Annotated[ContactSessionRequest, Tag(ContactKind.called)]
    | Annotated[BallbarSessionRequest, Tag(BallbarKind.called)],
    Discriminator(
        _called,
        custom_error_type="session_kind",
        custom_error_message="Kind should be one of " + ", ".join(kind.called for kind in _KINDS),
    ),
]
AnySituation: TypeAlias = GuideReply | BallbarSessionReply
AnyPlan: TypeAlias = PlanReply | ContactPlanReply | StepsReply
AnyScene: TypeAlias = GuidedSceneReply | SceneReply


def kind_of(record: SessionRecord) -> KindOfSession:
    """Return the kind of a session."""
    return next(kind for kind in _KINDS if record.role in kind.roles)


def kind_called(name: str) -> KindOfSession:
    """Return the kind that a request for a plan names."""
    return next(kind for kind in _KINDS if kind.called == name)
