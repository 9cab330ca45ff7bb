"""The hands of a simulated cell: what a demonstration has the person do."""

from fastapi import status

from truepose.sessions.simulated import ACTIONS
from truepose.web.api.sessions.ballbar_replies import HandsReply
from truepose.web.api.sessions.ballbar_requests import HandsRequest
from truepose.web.context import Here
from truepose.web.resources import problems, resource

router = resource("/simulated-hands", tags=["simulated hands"])


@router.get("")
async def get_hands(here: Here) -> HandsReply:
    """Say what the simulated hands can do; nothing on a real cell."""
    desk = here.hands_desk
    return HandsReply(
        simulated=desk.simulated, actions=list(ACTIONS) if desk.simulated else [], holding=desk.holding
    )


@router.post("", status_code=status.HTTP_204_NO_CONTENT, responses=problems(400, 409, 413, 415, 422, 503))
async def use_hands(here: Here, wanted: HandsRequest) -> None:
    """Let the simulated hands do one thing; 409 with a sentence where that cannot be done now."""
    await here.hands_desk.do(wanted.action, wanted.details())
