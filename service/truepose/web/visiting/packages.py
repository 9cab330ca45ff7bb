"""What the pages use of other people's packages, as the build bundled it; compressed for who takes it so."""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request
from fastapi.responses import FileResponse
from starlette.exceptions import HTTPException

router = APIRouter(include_in_schema=False)
_BUNDLES: Final = Path(__file__).parents[1] / "static" / "packages"


@router.get("/static/packages/{name}", response_class=FileResponse)
async def package_file(name: str, request: Request) -> FileResponse:
    """Send a bundle; where the installation could not make it there is none."""
    script = next((path for path in _BUNDLES.glob("*.js") if path.name == name), None)
    if script is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    headers = {"Cache-Control": "no-cache", "Vary": "Accept-Encoding"}
    if "gzip" in request.headers.get("accept-encoding", ""):
        return FileResponse(
            script.with_suffix(".js.gz"),
            media_type="text/javascript",
            headers={**headers, "Content-Encoding": "gzip"},
        )
    return FileResponse(script, media_type="text/javascript", headers=headers)
