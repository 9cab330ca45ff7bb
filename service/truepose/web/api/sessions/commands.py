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
    """What somebody asks of a session, as by a button that they press."""

    model_config = example({
        "command": "confirm",
        "person": "Ada Byron",
        "prompt_id": 57,
        "step_id": "placement-1/pose-12/move",
        "tablet": "tablet-1",
    })

    command: Annotated[CommandName, Field(strict=False, description="One of the situation's `commands`.")]
    person: PersonName | None = Field(
        None, description="Who asks. Null: whoever is signed in; a halt needs no name."
    )
    prompt_id: PromptAnswered = None
    step_id: str | None = Field(
        None,
        max_length=200,
        description="The step that the person saw, or means: `stop-7`, `tool/initialise`. Null: the present "
        "one; without a ballbar of `retry` and `back` the newest that was done.",
        examples=["stop-7"],
    )
    tablet: Annotated[str, AfterValidator(tidy_name)] = Field(
        "",
        max_length=100,
        pattern=f"^$|{NAME_PATTERN}",
        description="At which they stand.",
        examples=["tablet-1"],
    )
    reason: str = Field(
        "",
        max_length=2000,
        description="Of a skip, a pause, a stop; how one knows that a ballbar is off that cannot be read.",
    )
    answer: Annotated[Answer | None, Field(strict=False)] = Field(None, description="To a suspicion.")
    seen_time_s: float | None = Field(
        None, ge=0, description="Cell time of the newest value that the person saw when confirming a motion."
    )
    accept_serial_number: str | None = Field(
        None,
        max_length=200,
        description="Of a confirmation: the instrument in question that is accepted; without it none is.",
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
    """What was done, or when it takes effect."""

    sentence: Said = Field(examples=["B2-T3: 300.4213 mm is stored."])
    entry: int | None = Field(description="Number of the ledger's entry; null where nothing was kept.")
    session: AnySituation


@router.post("/{id}/commands", responses=CHANGE)
async def command_session(here: Here, id: Id, wanted: CommandRequest, key: OptionalKey) -> CommandReply:
    """Ask something of a session. The answer comes when what it did is on disk.

    An answer names the prompt that the person saw by its `id`. With an `Idempotency-Key` a repeated
    request is done once and gets the same answer. Another instrument than the expected one is accepted only
    by its serial number; confirmed without it, the session asks the instrument again who it is.
    """
    # Before anything is refused: a refusal is on record under the command's name too.
    current_request().command = wanted.command
    await require_authority(here, id, wanted.command)
    kind = kind_of(await here.sessions.get(id))
    answer = await here.session_desk.act(id, wanted.act(key), key)
    session = cast(AnySituation, await kind.situation(here, id))
    return CommandReply(sentence=in_words(answer.sentence), entry=answer.entry, session=session)
