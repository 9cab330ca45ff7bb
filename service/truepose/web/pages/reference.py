"""What every application shows: its API's reference, its error codes, and the styles and scripts of pages.

The usual OpenAPI pages need megabytes of script, from a content network or a package that lags years behind.
A reference that names every route, field, unit and error needs none.
"""

from http import HTTPStatus
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException

from truepose.messages.error_codes import CODES, explain
from truepose.web.pages.rendering import MEDIA_TYPES, Visited, file_response

router = APIRouter(include_in_schema=False)
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
    from truepose.reports.pages import page_styles

    return file_response(request, page_styles().encode(), MEDIA_TYPES[".css"])


@router.get("/static/tokens.css", response_class=Response)
async def colours(request: Request) -> Response:
    """Send the colours of everything that is shown."""
    from truepose.reports.pages import page_tokens

    return file_response(request, page_tokens().encode(), MEDIA_TYPES[".css"])


@router.get("/static/{name}", response_class=Response)
async def static_file(request: Request, name: str) -> Response:
    """Send a style or a script of the plain pages and of what stands around reports."""
    # Compared with what is there, and only then joined to the folder: no name leads out of it.
    if name not in {path.name for path in _STATIC.iterdir() if path.is_file()}:  # one segment of the path
        raise HTTPException(HTTPStatus.NOT_FOUND)
    return file_response(request, (_STATIC / name).read_bytes(), MEDIA_TYPES[Path(name).suffix])


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


_BUNDLES: Final = _STATIC / "packages"


@router.get("/static/packages/{name}", response_class=Response)
async def package_file(name: str, request: Request) -> Response:
    """Send a bundle; where the installation could not make it there is none."""
    found = next((path for path in _BUNDLES.glob("*.*s") if path.name == name), None)
    if found is None:
        raise HTTPException(HTTPStatus.NOT_FOUND)
    media_type = MEDIA_TYPES[found.suffix]
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return file_response(request, found.read_bytes(), media_type, {"Vary": "Accept-Encoding"})
    packed = found.with_name(f"{name}.gz").read_bytes()
    return file_response(request, packed, media_type, {"Vary": "Accept-Encoding", "Content-Encoding": "gzip"})


_GROUP: Final = len("TP-")  # where in a code the digit of its group stands


@router.get("/errors", response_class=HTMLResponse)
async def errors_page(visit: Visited) -> HTMLResponse:
    """List every code with what happened."""
    groups = [
        (visit.words.say(f"page.errors.group.{digit}"), [explain(code, visit.words) for code in codes])
        for digit, codes in groupby(CODES, lambda code: code[_GROUP])
    ]
    return visit.page("errors/errors.html", groups=groups)


@router.get("/errors/{code}", response_class=HTMLResponse)
async def error_page(visit: Visited, code: str) -> HTMLResponse:
    """Say what a code means, for the data too, and what to do now."""
    wanted = code.upper()
    if wanted not in CODES:
        return visit.page("errors/no_error.html", HTTPStatus.NOT_FOUND, code=code)
    return visit.page("errors/error.html", told=explain(wanted, visit.words), sentence="")
