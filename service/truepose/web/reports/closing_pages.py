"""Closing a session, for people: the certificates that its readings rest on, and who signs for them."""

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.web.reports.conditions import closing_sentence
from truepose.web.requests.parameters import Id
from truepose.web.visiting.visits import Visited

router = APIRouter(include_in_schema=False)


@router.get("/sessions/{id}/closing", response_class=HTMLResponse)
async def closing_page(visit: Visited, id: Id) -> HTMLResponse:
    """Show what a session was closed as, or a form that closes it."""
    here = visit.here
    record, closing = await here.sessions.get(id), await here.closings.of_session(id)
    papers = closing.certificates if closing else await here.closing_desk.certificates(id)
    return visit.page(
        "sessions/closing.html",
        place="work",
        record=record,
        closing=closing,
        sentence=visit.words.spoken(closing_sentence(closing)),
        papers=papers,
        faults=[visit.words.spoken(one.fault) for one in papers if not one.proves],
    )
