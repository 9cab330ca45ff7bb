"""Sends the operator's two pages, their modules, their style and their texts.

The pages hold nothing of a session: they ask the API. So one tablet may keep a page open through a restart
of the service, and what it shows afterwards is what the service says then.
"""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter
from fastapi.responses import FileResponse, HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.web.rendering import page
from truepose.words.catalogue import LANGUAGES, TABLET, texts_file

router = APIRouter(include_in_schema=False)
_HERE: Final = Path(__file__).parent
_SENT: Final = {
    ".js": (_HERE / "static", "text/javascript"),
    ".css": (_HERE / "static", "text/css"),
}
# A tablet asks again each time, and is told that nothing has changed: pages and texts never mix versions.
_HEADERS: Final = {"Cache-Control": "no-cache"}


@router.get("/operator", response_class=HTMLResponse)
async def operator_page() -> HTMLResponse:
    """Show the sessions and the start of a new one."""
    return page("operator.html")


@router.get("/operator/{id}", response_class=HTMLResponse)
async def session_page(id: int) -> HTMLResponse:
    """Show one session, a step a screen."""
    return page("session.html", id=id)


@router.get("/static/tablet/{name}", response_class=Response)
async def tablet_file(name: str) -> Response:
    """Send a module, the style or the texts of one language."""
    if Path(name).suffix == ".json":
        return _texts(Path(name).stem)
    folder, media_type = _SENT.get(Path(name).suffix, (_HERE, ""))
    # `name` is one path segment, and only what lies in that folder is sent.
    if name not in {path.name for path in folder.iterdir() if path.is_file()} or not media_type:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return FileResponse(folder / name, media_type=media_type, headers=_HEADERS)


def _texts(language: str) -> FileResponse:
    if language not in LANGUAGES:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return FileResponse(texts_file(language, TABLET), media_type="application/json", headers=_HEADERS)
