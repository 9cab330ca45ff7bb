"""Language and units of an answer: as the address asks, or asked before, else as the client prefers.

A program that names no language is answered in English and in the units that are kept.
"""

import re
from collections.abc import Iterable
from contextvars import ContextVar
from functools import cached_property
from typing import Annotated, Final

from fastapi import Request
from pydantic import BeforeValidator
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from truepose.messages.catalogue import ENGLISH, IN_ENGLISH, LANGUAGES, Catalogue, catalogue
from truepose.messages.message import Text
from truepose.messages.units import Units

# RFC 9110, 12.4.2: what Python reads as a number beside that (nan, 1e9, 1_0) is none here.
_WEIGHT: Final = re.compile(r"q=(0(?:\.[0-9]{0,3})?|1(?:\.0{0,3})?)", re.ASCII | re.IGNORECASE)


def wanted_words(request: Request) -> Catalogue:
    """Return the words of the language that a visitor wants."""
    asked = request.query_params.get("language", "")
    kept = request.cookies.get("language", "")
    return words_in([asked, kept, *accepted(request)], wanted_units(request))


def words_in(wanted: Iterable[str], units: Units) -> Catalogue:
    """Return the words of the first language that there is, in units; English where there is none."""
    spoken = next((language for language in wanted if language in LANGUAGES), ENGLISH)
    return catalogue(Catalogue(spoken, units).tag)


def accepted(request: HTTPConnection) -> list[str]:
    """Return the languages that whoever asks prefers, the most wanted first."""
    return preferred_languages(request.headers.get("accept-language", ""))


def wanted_units(request: HTTPConnection) -> Units:
    """Return the units that a visitor wants: of what the address does not name, those asked for before."""
    kept, asked = (where.get("units", "").split("-") for where in (request.cookies, request.query_params))
    return Units.of([*kept, *asked])


def preferred_languages(accepted: str) -> list[str]:
    """Return the languages of an `Accept-Language` header (RFC 9110, 12.5.4), the most wanted first."""
    weighed = [_weighed(part) for part in accepted.split(",") if part.strip()]
    return [language for weight, language in sorted(weighed, key=lambda one: -one[0]) if weight > 0.0]


def _weighed(part: str) -> tuple[float, str]:
    """Return the weight and the primary tag of e.g. `fr-CH;q=0.8`; what cannot be read weighs nothing."""
    tag, _, quality = (piece.strip() for piece in part.partition(";"))
    found = _WEIGHT.fullmatch(quality or "q=1")
    return float(found[1]) if found else 0.0, tag.partition("-")[0].lower()


class _Reader:
    """Whoever asks, read off the request once something is said to them."""

    def __init__(self, scope: Scope) -> None:
        self._scope = scope

    @cached_property
    def words(self) -> Catalogue:
        asked = HTTPConnection(self._scope)
        return words_in(accepted(asked), wanted_units(asked))


_READER: Final[ContextVar[_Reader | None]] = ContextVar("reader", default=None)


class LanguageMiddleware:
    """ASGI middleware: has answers be in the words of whoever asks."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on."""
        if scope["type"] == "http":
            _READER.set(_Reader(scope))
        await self._app(scope, receive, send)


def reader_words() -> Catalogue:
    """Return the words of whoever asks; English where nobody does."""
    reader = _READER.get()
    return IN_ENGLISH if reader is None else reader.words


def in_words(text: Text) -> str:
    """Return a text as whoever asks reads it."""
    return reader_words().spoken(text)


def say(text: Text | None) -> str | None:
    """Return a text as whoever asks reads it; None where nothing is said."""
    return None if text is None else in_words(text)


Said = Annotated[str, BeforeValidator(in_words)]
SaidOrNull = Annotated[str | None, BeforeValidator(say)]
