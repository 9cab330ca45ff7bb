"""The API's reference, rendered here, and the styles and scripts of all pages.

The usual OpenAPI pages need megabytes of script, from a content network or a package that lags years behind.
A reference that names every route, field, unit and error needs none.
"""

from http import HTTPStatus
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.web.visiting import packages
from truepose.web.visiting.files import sent
from truepose.web.visiting.visits import Visited

router = APIRouter(include_in_schema=False)
router.routes += packages.router.routes
_MEDIA: Final = {".css": "text/css", ".js": "text/javascript"}
_STATIC: Final = Path(__file__).parents[1] / "static"


@router.get("/docs", response_class=HTMLResponse)
async def api_page(visit: Visited) -> HTMLResponse:
    """Show the reference of the API, from the document at /openapi.json."""
    document = visit.request.app.openapi()
    operations = list(_operations(document))
    return visit.page("api.html", document=document, operations=operations, base=str(visit.request.base_url))


@router.get("/static/report.css", response_class=Response)
async def report_style(request: Request) -> Response:
    """Send the style of reports, which a report in a file carries within it."""
    from truepose.reports import page_styles

    return sent(request, page_styles().encode(), _MEDIA[".css"])


@router.get("/static/tokens.css", response_class=Response)
async def colours(request: Request) -> Response:
    """Send the colours of everything that is shown."""
    from truepose.reports import page_tokens

    return sent(request, page_tokens().encode(), _MEDIA[".css"])


@router.get("/static/{name}", response_class=Response)
async def static_file(request: Request, name: str) -> Response:
    """Send a style or a script of the plain pages and of what stands around reports."""
    if name not in {path.name for path in _STATIC.iterdir() if path.is_file()}:  # one segment of the path
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return sent(request, (_STATIC / name).read_bytes(), _MEDIA[Path(name).suffix])


def _operations(document: dict[str, Any]) -> Any:
    """Yield method, path and operation with its parameters and replies ready to print."""
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {
                "method": method.upper(),
                "path": path,
                "summary": operation.get("description") or operation["summary"],
                "parameters": operation.get("parameters", []),
                "bodies": _contents(operation.get("requestBody", {})),
                "replies": [
                    (status, reply["description"], _contents(reply))
                    for status, reply in operation["responses"].items()
                ],
            }


def _contents(holder: dict[str, Any]) -> list[tuple[str, list[str]]]:
    """Return media type and names of schemas, of a body or a reply."""
    return [
        (media, sorted(set(_schema_names(content.get("schema", {})))))
        for media, content in holder.get("content", {}).items()
    ]


def _schema_names(schema: Any) -> list[str]:
    if isinstance(schema, dict):
        found = [schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else []
        return found + [name for part in schema.values() for name in _schema_names(part)]
    if isinstance(schema, list):
        return [name for part in schema for name in _schema_names(part)]
    return []
