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
    """How a device identified itself, if this was new information."""

    device: IdentityOf
    finding: Finding = Field(
        description="`foreign`: a person must accept the device; `accepted`: `person` accepted it."
    )
    serial_number: Annotated[str | None, null_if_empty("serial")] = Field(
        description="Serial number reported by the device; null if it reports none.", examples=["391234"]
    )
    expected_serial_number: Annotated[str | None, null_if_empty("expected")] = Field(
        description="Serial number in the cell file or of the session so far; null if there is none.",
        examples=["390003"],
    )
    person: str | None = Field(description="Person who accepted the device.", examples=["Ada Byron"])


People = Annotated[
    list[str],
    Field(
        description="People permitted to act, from the cell file; empty if any name is accepted.",
        examples=[["Ada Byron", "Grace Hopper"]],
    ),
]


class PromptReply(Reply):
    """A prompt for a person; nothing moves until it is answered."""

    id: Number = Field(
        description="Identifier of the prompt, unique; the answer refers to it as `prompt_id`.", examples=[57]
    )
    message: Said = Field(examples=["Is the cell clear?"])
    picture: str = Field(
        description="Address of the picture to show beside the prompt.", examples=["/api/v1/sessions/3/scene"]
    )
    answered_by: CommandName = Field(description="Command that answers the prompt.", examples=["confirm"])
    leads_to: list[int] = Field(
        description="Configurations to which the arm may move after the answer.", examples=[[1, 2]]
    )
    people: People


def prompt_reply(session_id: int, asked: Prompt | None) -> PromptReply | None:
    """Return a prompt as it travels; None where nothing is asked."""
    return None if asked is None else PromptReply.of(asked, picture=f"/api/v1/sessions/{session_id}/scene")


class SituationReply(Reply):
    """Current situation of a session."""

    id: RecordId
    kind: str = Field(description="Kind of session.", examples=["tracker"])
    name: str = Field(examples=["left arm"])
    state: SessionState
    reason: Said = Field(description="Reason for the state.")
    reason_key: ReasonKey
    simulated: bool = Field(description="True if no real robot or instrument takes part.")
    robot: str = Field(examples=["ABB IRB 120"])
    prompt: PromptReply | None = Field(
        description="Prompt that is waiting for an answer; null if there is none."
    )
    trouble: SaidOrNull = Field(
        description="Reason why the session waits for the disk; null if it is not waiting."
    )
    motion_notice: SaidOrNull = Field(
        description="Limitations of this software once the arm moves, shown to the person who confirms; "
        "null without a robot."
    )
    people: People
    ledger_number: int | None = Field(description="Number of the latest ledger entry; null before the first.")
    robot_moving: bool
    commands: list[CommandName] = Field(description="Commands available now.")
    watching: int = Field(description="Number of tablets that follow the session.", examples=[2])
    identities: list[IdentityReply] = Field(
        description="Devices that identified themselves, with the people who accepted them."
    )


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
