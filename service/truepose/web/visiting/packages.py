"""What the pages use of other people's packages, as the build bundled it; compressed for who takes it so."""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi import APIRouter, Request
from fastapi.responses import Response
from starlette.exceptions import HTTPException

from truepose.web.visiting.files import sent

router = APIRouter(include_in_schema=False)
_SCRIPT: Final = "text/javascript"
_BUNDLES: Final = Path(__file__).parents[1] / "static" / "packages"


@router.get("/static/packages/{name}", response_class=Response)
async def package_file(name: str, request: Request) -> Response:
    """Send a bundle; where the installation could not make it there is none."""
    script = next((path for path in _BUNDLES.glob("*.js") if path.name == name), None)
    if script is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return sent(request, script.read_bytes(), _SCRIPT, {"Vary": "Accept-Encoding"})
    packed = script.with_suffix(".js.gz").read_bytes()
    return sent(request, packed, _SCRIPT, {"Vary": "Accept-Encoding", "Content-Encoding": "gzip"})
