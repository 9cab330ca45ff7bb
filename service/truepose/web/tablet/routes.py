"""Sends the operator's pages, their modules, their style and their texts.

The pages hold nothing of a session: they ask the API. So one tablet may keep a page open through a restart
of the service, and what it shows afterwards is what the service says then.
"""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.web.visits import Visited
from truepose.words.catalogue import LANGUAGES, TABLET, texts_file

router = APIRouter(include_in_schema=False)
_HERE: Final = Path(__file__).parent
_STATIC: Final = _HERE / "static"
_TYPES: Final = {".js": "text/javascript", ".css": "text/css", ".json": "application/json"}
_FILES: Final = {path.relative_to(_STATIC).as_posix(): path for path in _STATIC.glob("*/*.*")}
_TEXTS: Final = {f"common/{language}.json": texts_file(language, TABLET) for language in LANGUAGES}
# A tablet asks again each time, and is told that nothing has changed: pages and texts never mix versions.
_HEADERS: Final = {"Cache-Control": "no-cache"}


@router.get("/operator", response_class=HTMLResponse)
async def operator_page(visit: Visited) -> HTMLResponse:
    """Show the sessions and the start of a new one."""
    return visit.page("operator.html")


@router.get("/operator/{id}", response_class=HTMLResponse)
async def session_page(visit: Visited, id: int) -> HTMLResponse:
    """Show one session, a step a screen."""
    return visit.page("ballbar_session.html", id=id)


@router.get("/static/tablet/{name:path}", response_class=Response)
async def tablet_file(name: str) -> Response:
    """Send a module, the style or the texts of one language."""
    file = (_FILES | _TEXTS).get(name)
    if file is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return FileResponse(file, media_type=_TYPES[file.suffix], headers=_HEADERS)
