"""A page that cannot be shown now says so as a page: who reads it has a browser, and no document in mind."""

from http import HTTPStatus

from fastapi import Request
from fastapi.responses import HTMLResponse

from truepose.web.visiting.visits import visit_of
from truepose.words.error_codes import explained

_HTML = "text/html"
_API = "/api/"


def wants_a_page(request: Request) -> bool:
    """Whether somebody looks by a browser, and not at what is for programs."""
    return _HTML in request.headers.get("accept", "") and not request.url.path.startswith(_API)


def refused_page(request: Request, status: HTTPStatus, sentence: str, code: str) -> HTMLResponse:
    """Return the page of a code with the sentence of what happened here."""
    visit = visit_of(request, request.app.state.context)
    return visit.page("errors/error.html", status, told=explained(code, visit.words), sentence=sentence)
