"""What a simulated cell is told by hand: what goes wrong in it, and what the person in it does."""

from typing import Annotated, Any, Literal

from fastapi import status
from pydantic import Field

from truepose.sessions.simulated import ACTIONS
from truepose.web.api.sessions.ballbar_replies import HandsReply
from truepose.web.api.sessions.ballbar_requests import HandsRequest
from truepose.web.context import Here
from truepose.web.resources import Id, problems, resource
from truepose.web.schemas import Number, PersonName, Reply, Request, example, whole

FaultKind = Annotated[
    str,
    Field(
        min_length=1,
        max_length=40,
        pattern="^[a-z_]+$",
        description="Kind of fault (see docs/faults.md).",
        examples=["beam_broken"],
    ),
]
Text = Annotated[str, Field(max_length=64)]
Components = Annotated[list[float], Field(min_length=3, max_length=3)]
Value = float | Text | Components


class FaultRequest(Request):
    """A fault to inject, like a `[[fault]]` of a file."""

    model_config = example({
        "person": "Ada Byron",
        "kind": "link_cut",
        "keys": {"device": "robot", "configuration": 12, "for_s": 8},
    })

    person: PersonName
    kind: FaultKind
    keys: dict[str, Value] = Field(
        default_factory=dict,
        max_length=16,
        description="Keys of the fault, including its trigger; numbers are in the unit at the end of the "
        "name.",
        examples=[{"configuration": 12}],
    )

    def said(self) -> dict[str, object]:
        """Return the keys as the cell takes them: whole numbers without a fraction."""
        return {key: whole(value) for key, value in self.keys.items()}


class EndFaultRequest(Request):
    """Person who ends a fault."""

    person: PersonName


class FaultKeyReply(Reply):
    """A key of a kind of fault."""

    key: str = Field(examples=["by_mm"])
    type: Literal["number", "whole", "text", "vector"] = Field(description="`vector`: three numbers.")
    required: bool


class FaultKindReply(Reply):
    """A kind of fault with its keys; trigger keys come last."""

    kind: FaultKind
    keys: list[FaultKeyReply]


class FaultReply(Reply):
    """A fault of the cell."""

    number: Number
    kind: FaultKind
    keys: dict[str, Value] = Field(description="Keys as given.", examples=[{"configuration": 12}])
    state: Literal["waiting", "active", "over"]
    begun_s: float | None = Field(
        description="Cell time at which the fault was triggered; null if not triggered yet."
    )
    over_s: float | None = Field(description="Cell time at which the fault ended; null if not ended yet.")
    struck: int = Field(description="Number of readings, motions or connections affected.")
    person: str | None = Field(
        description="Person who injected the fault; null if the fault comes from a file.",
        examples=["Ada Byron"],
    )


class FaultsReply(Reply):
    """Available kinds of faults and the present faults."""

    simulated: bool = Field(description="False if the cell is real, so no faults can be injected.")
    now_s: float | None = Field(description="Present cell time.", examples=[312.5])
    kinds: list[FaultKindReply]
    faults: list[FaultReply]


class FaultGivenReply(Reply):
    """Number of the injected fault."""

    number: Number


def faults_reply(kinds: list[dict[str, Any]], given: dict[str, Any]) -> FaultsReply:
    """Return what the cell says of its faults."""
    return FaultsReply.model_validate({
        "simulated": True,
        "now_s": given["now_s"],
        "kinds": kinds,
        "faults": given["faults"],
    })


router = resource("/simulated-faults", tags=["simulated faults"])
_ACT = problems(400, 409, 413, 415, 422, 503)


@router.get("", responses=problems(503))
async def get_faults(here: Here) -> FaultsReply:
    """List the available kinds of faults and the state of each fault; empty for a real cell."""
    desk = here.faults_desk
    if not desk.simulated:
        return FaultsReply(simulated=False, now_s=None, kinds=[], faults=[])
    return faults_reply(await desk.kinds(), await desk.given())


@router.post("", status_code=status.HTTP_201_CREATED, responses=_ACT)
async def give_fault(here: Here, wanted: FaultRequest) -> FaultGivenReply:
    """Inject a fault into the simulated cell; 422 with an explanation if it is invalid."""
    return FaultGivenReply(number=await here.faults_desk.give(wanted.person, wanted.kind, wanted.said()))


@router.post("/{id}/end", status_code=status.HTTP_204_NO_CONTENT, responses=_ACT)
async def end_fault(here: Here, id: Id, who: EndFaultRequest) -> None:
    """End a fault now, whether or not it has been triggered."""
    await here.faults_desk.end(who.person, id)


hands_router = resource("/simulated-hands", tags=["simulated hands"])


@hands_router.get("")
async def get_hands(here: Here) -> HandsReply:
    """Return the available actions of the simulated operator; none for a real cell."""
    desk = here.hands_desk
    return HandsReply(
        simulated=desk.simulated, actions=list(ACTIONS) if desk.simulated else [], holding=desk.holding
    )


@hands_router.post("", status_code=status.HTTP_204_NO_CONTENT, responses=_ACT)
async def use_hands(here: Here, wanted: HandsRequest) -> None:
    """Have the simulated operator perform an action; 409 with an explanation if it is not possible now."""
    await here.hands_desk.do(wanted.action, wanted.details())
