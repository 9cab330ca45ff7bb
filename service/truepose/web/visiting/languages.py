"""The language and units of a page: what its address asks for, or asked for before, else the browser's."""

from fastapi import Request

from truepose.words.catalogue import ENGLISH, LANGUAGES, Catalogue, catalogue
from truepose.words.units import Units


def wanted_words(request: Request) -> Catalogue:
    """Return the words of the language that a visitor wants."""
    asked = request.query_params.get("language", "")
    kept = request.cookies.get("language", "")
    wanted = [asked, kept, *preferred(request.headers.get("accept-language", ""))]
    spoken = next((language for language in wanted if language in LANGUAGES), ENGLISH)
    units = wanted_units(request)
    return catalogue(Catalogue(spoken, units).tag)


def wanted_units(request: Request) -> Units:
    """Return the units that a visitor wants: of what the address does not name, those asked for before."""
    kept, asked = (_tokens(where.get("units", "")) for where in (request.cookies, request.query_params))
    return Units.of([*kept, *asked])


def _tokens(told: str) -> list[str]:
    return told.split("-")


def preferred(accepted: str) -> list[str]:
    """Return the languages of an `Accept-Language` header (RFC 9110, 12.5.4), the most wanted first."""
    weighed = [_weighed(part) for part in accepted.split(",") if part.strip()]
    return [language for weight, language in sorted(weighed, key=lambda one: -one[0]) if weight > 0.0]


def _weighed(part: str) -> tuple[float, str]:
    """Return the weight and the primary tag of e.g. `fr-CH;q=0.8`; what cannot be read weighs nothing."""
    tag, _, quality = part.partition(";")
    try:
        weight = float(quality.strip().removeprefix("q=")) if quality else 1.0
    except ValueError:
        weight = 0.0
    return weight, tag.strip().partition("-")[0].lower()
