"""Page rendering: a visit in its language, units and look, templates, and parts that take long to draw.

What an address asks for (`?language=fr&look=dark&units=inch`) is kept in a cookie: no link carries it on.
A file is asked for again each time and sent again only where it has changed: so pages never mix versions, and
a tablet that opens its tenth page fetches no script.
"""

import asyncio
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from http import HTTPStatus
from pathlib import Path
from typing import Annotated, Final

from fastapi import Depends, Query, Request
from fastapi.responses import HTMLResponse, Response
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from truepose.analysis.page_services import Draw
from truepose.domain.people import Role, reaches
from truepose.messages.catalogue import LANGUAGES, Catalogue, catalogue
from truepose.messages.templates import in_units
from truepose.people.register import Caller
from truepose.storage.caches import rendered_page
from truepose.web.context import Context, Here
from truepose.web.middleware.language import wanted_words
from truepose.web.middleware.rights import current_request, may_ask

MEDIA_TYPES: Final = {".css": "text/css", ".js": "text/javascript"}  # of what pages load, by its ending
_COMPRESSED: Final = ("text/", "application/json")  # on their way: the same tag stands for both forms


def file_response(
    request: Request, body: bytes, media_type: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return a file, or that the browser which asks has it already."""
    weak = "W/" if media_type.startswith(_COMPRESSED) else ""
    tag = f'"{hashlib.sha256(body).hexdigest()}"'
    head = {"Cache-Control": "private, no-cache", "ETag": f"{weak}{tag}", **(headers or {})}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=head)
    return Response(body, media_type=media_type, headers=head)


_HERE: Final = Path(__file__).parents[1]
_TEMPLATES: Final = Environment(
    loader=FileSystemLoader([
        _HERE / "templates",
        _HERE / "tablet" / "templates",
        _HERE.parent / "reports" / "templates",  # for tables that reports show too
    ]),
    autoescape=True,
    undefined=StrictUndefined,
    finalize=in_units,
)
_TEMPLATES.globals["parts"] = _TEMPLATES.get_template("parts.html").module


def render(template: str, **context: object) -> str:
    """Return a template of this package, filled in."""
    return _TEMPLATES.get_template(template).render(**context)


def prepare(*beginnings: str) -> None:
    """Compile templates whose names begin so, a tenth of a second of work, before somebody waits for it."""
    for name in _TEMPLATES.list_templates():
        if name.startswith(beginnings):
            _TEMPLATES.get_template(name)


def moment(said: str) -> str:
    """Return a day as it is, and a time to the minute: nobody reads milliseconds."""
    if "T" not in said:
        return said
    return datetime.fromisoformat(said).astimezone(UTC).strftime("%Y-%m-%d %H:%M UTC")


LOOKS: Final = ("system", "light", "dark", "contrast")
_CHOICES: Final = {"language": LANGUAGES, "look": LOOKS}
_UNITS: Final = {
    "mm": "shell.units.mm",
    "inch": "shell.units.inch",
    "deg": "shell.units.deg",
    "rad": "shell.units.rad",
    "c": "shell.units.c",
    "f": "shell.units.f",
}
_YEAR_S: Final = 365 * 24 * 3600


@dataclass(frozen=True, slots=True)
class Visit:
    """Who asks for a page, and how it is shown to them."""

    request: Request
    here: Context
    words: Catalogue
    look: str

    @property
    def caller(self) -> Caller:
        """Who asks."""
        return current_request().caller

    def may(self, operation: str) -> bool:
        """Whether they may ask for an operation."""
        return self.caller.everybody or may_ask(self.caller, operation)

    @property
    def may_command(self) -> bool:
        """Whether they may ask more of a session than to halt."""
        role = self.caller.role
        return self.caller.everybody or (role is not None and reaches(role, Role.OPERATOR))

    def page(self, template: str, status: HTTPStatus = HTTPStatus.OK, **context: object) -> HTMLResponse:
        """Return a page, filled in; `say` gives its words, `visit` is this visit."""
        shown = {"visit": self, "here": self.here, "words": self.words, "say": self.words.say}
        answer = HTMLResponse(render(template, **shown, **context), status)
        answer.headers["Content-Language"] = self.words.language
        # Language, look and units come from there; a cache that did not know would give one reader the page
        # of another.
        answer.headers["Vary"] = "Accept-Language, Cookie"
        for name, value in self._asked().items():
            answer.set_cookie(name, value, max_age=_YEAR_S, samesite="lax")
        return answer

    def address(self, **choices: str) -> str:
        """Return the address of this page with other choices."""
        return f"?{self.request.url.include_query_params(**choices).query}"

    @property
    def languages(self) -> list[tuple[str, str]]:
        """Every language there is, with its own name."""
        return [(language, catalogue(language).say("page.language")) for language in LANGUAGES]

    @property
    def units(self) -> list[tuple[str, str, bool]]:
        """Each unit there is: as an address names it, its key of the catalogue, whether it is chosen."""
        chosen = self.words.units.chosen
        return [(token, key, token in chosen) for token, key in _UNITS.items()]

    def _asked(self) -> dict[str, str]:
        asked = self.request.query_params
        chosen = {name: asked[name] for name, known in _CHOICES.items() if asked.get(name) in known}
        return chosen | ({"units": "-".join(self.words.units.chosen)} if "units" in asked else {})


def visit_of(request: Request, here: Context) -> Visit:
    """Return a request as a visit."""
    wanted = (request.query_params.get("look"), request.cookies.get("look"))
    look = next((look for look in wanted if look in LOOKS), LOOKS[0])
    return Visit(request, here, wanted_words(request), look or LOOKS[0])


class MissingPageError(Exception):
    """An address names no record; `problems` answers with the page that says so."""


async def _visit(request: Request, here: Here) -> Visit:
    return visit_of(request, here)


Visited = Annotated[Visit, Depends(_visit)]


_AT_ONCE_S: Final = 0.3  # that a page waits for what is quick to draw
Whole = Annotated[bool, Query(description="Respond once the whole page has been rendered.")]


async def render_part(
    visit: Visit, of: str, draw: Draw, *, whole: bool, at_once_s: float = _AT_ONCE_S
) -> Markup | None:
    """Return a part of a page; None while it is being drawn, unless the whole page was asked for.

    `of` is all that the part follows from beside language and units; a page that is to be there at once waits
    `at_once_s` for it, which is what reading a kept drawing takes. Raises what `draw` raises.
    """
    drawing = visit.here.drawing_desk.kept.drawing(f"{visit.words.tag}\n{of}", draw)
    await asyncio.wait({drawing}, timeout=None if whole else at_once_s)
    return Markup(drawing.result().body.decode()) if drawing.done() else None


async def pdf_response(visit: Visit, page: str, name: str) -> Response:
    """Return a page as a PDF of that name; raises what a worker may raise."""
    from truepose.reports.paper import pdf_of

    of = f"pdf {rendered_page(page.encode()).sha256}"
    desk = visit.here.drawing_desk
    drawn = await desk.kept.drawn(of, lambda: desk.draw(pdf_of, page))
    named = {"Content-Disposition": f'inline; filename="{name}"'}
    return file_response(visit.request, drawn.body, "application/pdf", named)
