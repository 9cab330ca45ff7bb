"""Sends the operator's pages, their modules, their style and their texts.

The pages hold nothing of a session but its kind: they ask the API. So one tablet may keep a page open
through a restart of the service, and what it shows afterwards is what the service says then.
"""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.storage.errors import NotFoundError
from truepose.web.context import Context
from truepose.web.visiting.files import sent
from truepose.web.visiting.visits import Visited
from truepose.words.catalogue import LANGUAGES, STORED, TABLET, TRACKER_TABLET, texts_file

router = APIRouter(include_in_schema=False)
_HERE: Final = Path(__file__).parent
_STATIC: Final = _HERE / "static"
_TYPES: Final = {".js": "text/javascript", ".css": "text/css", ".json": "application/json"}
_FILES: Final = {path.relative_to(_STATIC).as_posix(): path for path in _STATIC.glob("*/*.*")}
_TEXTS: Final = {
    f"{room}/{language}.json": texts_file(language, texts)
    for room, texts in (("common", TABLET), ("tracker", TRACKER_TABLET), ("stored", STORED))
    for language in LANGUAGES
}


@router.get("/operator", response_class=HTMLResponse)
async def operator_page(visit: Visited) -> HTMLResponse:
    """Show the sessions and the start of a new one."""
    return visit.page("operator.html")


@router.get("/operator/{id}", response_class=HTMLResponse)
async def session_page(visit: Visited, id: int) -> HTMLResponse:
    """Show one session, a step a screen."""
    return visit.page(await _template_of(visit.here, id), id=id)


async def _template_of(here: Context, id: int) -> str:
    """Return the page of a session's kind; that of one that is not there says so."""
    try:
        role = (await here.sessions.get(id)).role
    except NotFoundError:
        return "ballbar_session.html"
    return "ballbar_session.html" if role == "ballbar" else "tracker_session.html"


@router.get("/static/tablet/{name:path}", response_class=Response)
async def tablet_file(request: Request, name: str) -> Response:
    """Send a module, the style or the texts of one language."""
    file = (_FILES | _TEXTS).get(name)
    if file is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return sent(request, file.read_bytes(), _TYPES[file.suffix])
