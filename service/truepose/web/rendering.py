"""Templates of the pages for people."""

from http import HTTPStatus
from pathlib import Path
from typing import Final

from fastapi.responses import HTMLResponse
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from truepose.words.catalogue import LANGUAGES, Catalogue, catalogue

_HERE: Final = Path(__file__).parent
_TEMPLATES: Final = Environment(
    loader=FileSystemLoader([_HERE / "templates", _HERE / "tablet" / "templates"]),
    autoescape=True,
    undefined=StrictUndefined,
)


def page(template: str, status: HTTPStatus = HTTPStatus.OK, **context: object) -> HTMLResponse:
    """Return a page of this package's templates, filled in."""
    return HTMLResponse(_TEMPLATES.get_template(template).render(**context), status)


def spoken_page(
    words: Catalogue, template: str, status: HTTPStatus = HTTPStatus.OK, **context: object
) -> HTMLResponse:
    """Return a page in the language that was asked for; `say` fills in its texts."""
    others = [(one, catalogue(one).say("page.language")) for one in LANGUAGES if one != words.language]
    answer = page(template, status, words=words, say=words.say, others=others, **context)
    answer.headers["Content-Language"] = words.language
    answer.headers["Vary"] = "Accept-Language"
    return answer
