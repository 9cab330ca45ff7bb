"""A session planned as an earlier one: its stops, or as many chosen anew, in the cell of today."""

from fastapi import Response, status

from truepose.web.again.planning import plan_again, template_of
from truepose.web.context import Here
from truepose.web.jobs import queued
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id, OptionalKey, Sender
from truepose.web.resources import resource
from truepose.web.schemas.jobs import JobReply
from truepose.web.schemas.measurement.again import RepeatRequest

router = resource("/sessions", tags=["sessions"])


@router.post(
    "/{id}/again",
    status_code=status.HTTP_202_ACCEPTED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def plan_session_again(
    here: Here, id: Id, wanted: RepeatRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Plan a session as an earlier one of any kind; the job's result is the session. Nothing moves.

    Robot, kind, stops, nests and cups are those of then, unless they are chosen anew; the cell, its limits
    and its instruments are those of the cell file now.
    """
    template = await template_of(here, id)
    return await queued(here, await plan_again(here, template, wanted, key, sender), response)
