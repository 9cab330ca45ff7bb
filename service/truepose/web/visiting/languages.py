"""The language of a page: what its address asks for or asked for before, else what the browser prefers."""

from fastapi import Request

from truepose.words.catalogue import ENGLISH, LANGUAGES, Catalogue, catalogue


def wanted_words(request: Request) -> Catalogue:
    """Return the words of the language that a visitor wants."""
    asked = request.query_params.get("language", "")
    kept = request.cookies.get("language", "")
    wanted = [asked, kept, *preferred(request.headers.get("accept-language", ""))]
    return catalogue(next((language for language in wanted if language in LANGUAGES), ENGLISH))


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
