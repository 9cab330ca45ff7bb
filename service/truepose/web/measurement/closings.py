"""Closing sessions: as calibrated, on certificates that held or by a named person for a reason."""

from fastapi import status

from truepose.domain.cell.certificates import Closing
from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.measurement.closings import ClosingReply, ClosingRequest, closing_reply, open_reply

router = resource("/sessions", tags=["sessions"])


@router.get("/{id}/closing", responses=problems(404, 422, 503))
async def get_closing(here: Here, id: Id) -> ClosingReply:
    """Show what a session is closed as, and the certificates that its readings rest on."""
    await here.sessions.get(id)
    closing = await here.closings.of_session(id)
    return open_reply(await here.closing_desk.certificates(id)) if closing is None else closing_reply(closing)


@router.post(
    "/{id}/closing",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def close_session(here: Here, id: Id, wanted: ClosingRequest) -> ClosingReply:
    """Close a session that has ended, once and for all.

    As calibrated only where it finished and every certificate held when its last reading was taken, or with
    a reason that every report prints.
    """
    closing = Closing(id, wanted.closed_as, wanted.person, wanted.reason, ())
    return closing_reply(await here.closing_desk.close(closing))
