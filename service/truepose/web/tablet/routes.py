"""Sends the operator's pages, their modules, their style and their texts.

The pages hold nothing of a session but its kind: they ask the API. So one tablet may keep a page open
through a restart of the service, and what it shows afterwards is what the service says then.
"""

import json
from functools import cache
from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.messages.catalogue import LANGUAGES, TABLET, TRACKER_TABLET
from truepose.messages.translations import translations
from truepose.storage.errors import NotFoundError
from truepose.web.api.sessions.kind import KindOfSession
from truepose.web.api.sessions.kinds import kind_of
from truepose.web.context import Context
from truepose.web.pages.rendering import MEDIA_TYPES, Visited, file_response

router = APIRouter(include_in_schema=False)
_HERE: Final = Path(__file__).parent
_STATIC: Final = _HERE / "static"
_FILES: Final = {path.relative_to(_STATIC).as_posix(): path for path in _STATIC.glob("*/*.*")}
_TEXTS: Final = {"common": TABLET, "tracker": TRACKER_TABLET}


@router.get("/operator", response_class=HTMLResponse)
async def operator_page(visit: Visited) -> HTMLResponse:
    """Show the sessions and the start of a new one."""
    return visit.page("operator.html")


@router.get("/operator/{id}", response_class=HTMLResponse)
async def session_page(visit: Visited, id: int) -> HTMLResponse:
    """Show one session, a step a screen."""
    return visit.page(await _template_of(visit.here, id), id=id)


async def _template_of(here: Context, id: int) -> str:
    """Return the page of a session's kind; that of any kind says of one that is not there that it is not."""
    try:
        return kind_of(await here.sessions.get(id)).tablet_page
    except NotFoundError:
        return KindOfSession.tablet_page


@router.get("/static/tablet/{room}/{language}.json", response_class=Response)
async def tablet_texts(request: Request, room: str, language: str) -> Response:
    """Send the texts of one language that the pages of a room say."""
    if room not in _TEXTS or language not in LANGUAGES:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return file_response(request, _texts(_TEXTS[room], language), "application/json")


@cache
def _texts(domain: str, language: str) -> bytes:
    return json.dumps(translations(language, domain).texts(), ensure_ascii=False).encode()


@router.get("/static/tablet/{name:path}", response_class=Response)
async def tablet_file(request: Request, name: str) -> Response:
    """Send a module or the style."""
    # Looked up among the files that are there, never joined to a folder: no name leads out of it.
    file = _FILES.get(name)
    if file is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return file_response(request, file.read_bytes(), MEDIA_TYPES[file.suffix])
