"""Where a session stands and which devices answered, as far as that is the same for every kind."""

from typing import Annotated, TypeVar

from pydantic import Field

from truepose.domain.session import Finding, IdentityOf, SessionState
from truepose.exchange.results.document import null_if_empty
from truepose.messages.message import key_of
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.prompts import Prompt
from truepose.sessions.guide.guide import SessionStatus
from truepose.sessions.service import Attendance
from truepose.storage.records import SessionSetup
from truepose.web.middleware.language import Said, SaidOrNull
from truepose.web.schemas import Number, ReasonKey, RecordId, Reply


class IdentityReply(Reply):
    """What a device answered when it was asked who it is, where that said anything new."""

    device: IdentityOf
    finding: Finding = Field(description="`foreign` waits for a person; `accepted` says who it was.")
    serial_number: Annotated[str | None, null_if_empty("serial")] = Field(
        description="As it answered; null: it does not say.", examples=["391234"]
    )
    expected_serial_number: Annotated[str | None, null_if_empty("expected")] = Field(
        description="Of the cell file, or of the session so far; null: none.", examples=["390003"]
    )
    person: str | None = Field(description="Who accepted it.", examples=["Ada Byron"])


People = Annotated[
    list[str],
    Field(
        description="Who may act, as the cell file announces them; empty: whoever gives a name.",
        examples=[["Ada Byron", "Grace Hopper"]],
    ),
]


class PromptReply(Reply):
    """What a person is asked; nothing moves meanwhile."""

    id: Number = Field(description="An answer names it as `prompt_id`; no other has it.", examples=[57])
    message: Said = Field(examples=["Is the cell clear?"])
    picture: str = Field(description="What to draw beside it.", examples=["/api/v1/sessions/3/scene"])
    answered_by: CommandName = Field(description="The command.", examples=["confirm"])
    leads_to: list[int] = Field(description="Configurations to which the arm may go then.", examples=[[1, 2]])
    people: People


def prompt_reply(session_id: int, asked: Prompt | None) -> PromptReply | None:
    """Return a prompt as it travels; None where nothing is asked."""
    return None if asked is None else PromptReply.of(asked, picture=f"/api/v1/sessions/{session_id}/scene")


class SituationReply(Reply):
    """A session and where it stands."""

    id: RecordId
    kind: str = Field(description="What measures in it.", examples=["tracker"])
    name: str = Field(examples=["left arm"])
    state: SessionState
    reason: Said = Field(description="Why it is in this state.")
    reason_key: ReasonKey
    simulated: bool = Field(description="True: no robot and no instrument take part.")
    robot: str = Field(examples=["ABB IRB 120"])
    prompt: PromptReply | None = Field(description="What a person is asked now; null: nothing.")
    trouble: SaidOrNull = Field(description="Why the session waits for the disk; null where it does not.")
    motion_notice: SaidOrNull = Field(
        description="What this program cannot do once the arm moves: for whoever confirms; null: no robot."
    )
    people: People
    ledger_number: int | None = Field(description="Number of the newest entry; null before the first.")
    robot_moving: bool
    commands: list[CommandName] = Field(description="What may be asked of it now.")
    watching: int = Field(description="Tablets that follow the session.", examples=[2])
    identities: list[IdentityReply] = Field(description="Which devices answered, and who accepted them.")


S = TypeVar("S", bound=SituationReply)


def situation_reply(
    reply: type[S],
    id: int,
    setup: SessionSetup,
    found: SessionStatus | Situation,
    now: Attendance,
    **more: object,
) -> S:
    """Return where a session stands as it travels, with what its kind says besides."""
    return reply.of(
        found,
        now,
        **{
            "id": id,
            "simulated": setup.simulated,
            "robot": setup.cell.robot.name,
            "reason_key": key_of(found.reason),
            "prompt": prompt_reply(id, now.prompt),
            "people": list(now.people),
            "ledger_number": now.newest_entry,
            "commands": sorted(found.acts),
            **more,
        },
    )
