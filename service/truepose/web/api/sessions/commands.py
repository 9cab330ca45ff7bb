"""What people ask of a session: one route for every command to sessions of every kind."""

from typing import Annotated, cast

from pydantic import AfterValidator, Field

from truepose.domain.people import NAME_PATTERN, tidy_name
from truepose.sessions.ballbar.state import Answer
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.storage.records import RequestKey
from truepose.web.api.authority import require_authority
from truepose.web.api.sessions.kinds import AnySituation, kind_of
from truepose.web.context import Here
from truepose.web.middleware.language import Said, in_words
from truepose.web.middleware.rights import current_request, signed_in_name
from truepose.web.resources import CHANGE, Id, OptionalKey, resource
from truepose.web.schemas import (
    PersonName,
    PressedAt,
    PromptAnswered,
    Reply,
    Request,
    example,
    under_way_s,
)

router = resource("/sessions", tags=["sessions"])


class CommandRequest(Request):
    """A command to a session, like pressing a button."""

    model_config = example({
        "command": "confirm",
        "person": "Ada Byron",
        "prompt_id": 57,
        "step_id": "placement-1/pose-12/move",
        "tablet": "tablet-1",
    })

    command: Annotated[
        CommandName, Field(strict=False, description="One of the `commands` of the situation.")
    ]
    person: PersonName | None = Field(
        None,
        description="Person who gives the command. Null: the person who is signed in; a halt needs no name.",
    )
    prompt_id: PromptAnswered = None
    step_id: str | None = Field(
        None,
        max_length=200,
        description="Step that the user saw or refers to, such as `stop-7` or `tool/initialise`. Null: "
        "the present step; for `retry` and `back` in sessions without a ballbar, the last "
        "completed step.",
        examples=["stop-7"],
    )
    tablet: Annotated[str, AfterValidator(tidy_name)] = Field(
        "",
        max_length=100,
        pattern=f"^$|{NAME_PATTERN}",
        description="Tablet at which the person stands.",
        examples=["tablet-1"],
    )
    reason: str = Field(
        "",
        max_length=2000,
        description="Reason for a skip, pause or stop; or how the person knows that a ballbar that cannot "
        "be read is detached.",
    )
    answer: Annotated[Answer | None, Field(strict=False)] = Field(None, description="Answer to a suspicion.")
    seen_time_s: float | None = Field(
        None, ge=0, description="Cell time of the latest value shown to the person when confirming a motion."
    )
    accept_serial_number: str | None = Field(
        None,
        max_length=200,
        description="For a confirmation: serial number of the instrument to accept. Without it, no "
        "unexpected instrument is accepted.",
        examples=["391234"],
    )
    pressed_at_s: PressedAt = None

    def act(self, key: RequestKey | None) -> OperatorCommand:
        """Return what is asked."""
        return self.into(
            OperatorCommand,
            name=self.command,
            person=self.person or signed_in_name() or "",
            key=None if key is None else key.key,
            answer=self.answer.value if self.answer else "",
            accepted_serial=self.accept_serial_number or "",
            under_way_s=under_way_s(self.pressed_at_s),
        )


class CommandReply(Reply):
    """Result of a command, or when the command will take effect."""

    sentence: Said = Field(examples=["B2-T3: 300.4213 mm is stored."])
    entry: int | None = Field(description="Number of the ledger entry; null if none was written.")
    session: AnySituation


@router.post("/{id}/commands", responses=CHANGE)
async def command_session(here: Here, id: Id, wanted: CommandRequest, key: OptionalKey) -> CommandReply:
    """Send a command to a session. The response is sent once the effect is on disk.

    An answer to a prompt gives the `id` of the prompt that the person saw. A repeated request with the same
    `Idempotency-Key` is executed once and gets the same response. An instrument other than the expected one
    is accepted only by its serial number; if it is confirmed without one, the session asks the instrument to
    identify itself again.
    """
    # Before anything is refused: a refusal is on record under the command's name too.
    current_request().command = wanted.command
    await require_authority(here, id, wanted.command)
    kind = kind_of(await here.sessions.get(id))
    answer = await here.session_desk.act(id, wanted.act(key), key)
    session = cast(AnySituation, await kind.situation(here, id))
    return CommandReply(sentence=in_words(answer.sentence), entry=answer.entry, session=session)
