"""A visit: one request for a page, in the language, the units and the look that its visitor wants.

What an address asks for (`?language=fr&look=dark&units=inch`) is kept in a cookie: no link carries it on.
"""

from dataclasses import dataclass
from http import HTTPStatus
from typing import Annotated, Final

from fastapi import Depends, Request
from fastapi.responses import HTMLResponse

from truepose.operation.people.register import Caller
from truepose.web.context import Context, Here
from truepose.web.people.asking import asking
from truepose.web.people.rights import may_ask
from truepose.web.visiting.languages import wanted_words
from truepose.web.visiting.rendering import rendered
from truepose.words.catalogue import LANGUAGES, Catalogue, catalogue

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
        return asking().caller

    def may(self, operation: str) -> bool:
        """Whether they may ask for an operation."""
        return self.caller.everybody or may_ask(self.caller, operation)

    def page(self, template: str, status: HTTPStatus = HTTPStatus.OK, **context: object) -> HTMLResponse:
        """Return a page, filled in; `say` gives its words, `visit` is this visit."""
        shown = {"visit": self, "here": self.here, "words": self.words, "say": self.words.say}
        answer = HTMLResponse(rendered(template, **shown, **context), status)
        answer.headers["Content-Language"] = self.words.language
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


async def _visit(request: Request, here: Here) -> Visit:
    return visit_of(request, here)


Visited = Annotated[Visit, Depends(_visit)]
