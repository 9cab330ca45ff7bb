"""The faults of a simulated cell: what may go wrong, what does, and what has."""

from fastapi import status

from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.measurement.faults import (
    EndFaultRequest,
    FaultGivenReply,
    FaultRequest,
    FaultsReply,
    faults_reply,
)

router = resource("/simulated-faults", tags=["simulated faults"])
_ACT = problems(400, 409, 413, 415, 422, 503)


@router.get("", responses=problems(503))
async def get_faults(here: Here) -> FaultsReply:
    """Say what may go wrong in the simulated cell, and what became of each fault; nothing on a real cell."""
    desk = here.faults_desk
    if not desk.simulated:
        return FaultsReply(simulated=False, now_s=None, kinds=[], faults=[])
    return faults_reply(await desk.kinds(), await desk.given())


@router.post("", status_code=status.HTTP_201_CREATED, responses=_ACT)
async def give_fault(here: Here, wanted: FaultRequest) -> FaultGivenReply:
    """Have something go wrong in the simulated cell; 422 with a sentence where that makes no sense."""
    return FaultGivenReply(number=await here.faults_desk.give(wanted.person, wanted.kind, wanted.said()))


@router.post("/{id}/end", status_code=status.HTTP_204_NO_CONTENT, responses=_ACT)
async def end_fault(here: Here, id: Id, who: EndFaultRequest) -> None:
    """End a fault now, whatever it waits for."""
    await here.faults_desk.end(who.person, id)
