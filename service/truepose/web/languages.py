"""The language of a page: what its address asks for, else what the browser prefers, else English."""

from typing import Annotated

from fastapi import Depends, Request

from truepose.words.catalogue import ENGLISH, LANGUAGES, Catalogue, catalogue


def _asked(request: Request) -> Catalogue:
    asked = request.query_params.get("language", "")
    wanted = [asked, *preferred(request.headers.get("accept-language", ""))]
    return catalogue(next((language for language in wanted if language in LANGUAGES), ENGLISH))


def _kept(request: Request) -> str:
    """Return what links of a page carry on, so that the language that was asked for stays."""
    asked = request.query_params.get("language", "")
    return f"?language={asked}" if asked in LANGUAGES else ""


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


Words = Annotated[Catalogue, Depends(_asked)]
Kept = Annotated[str, Depends(_kept)]
