"""Whether a request may come in: by the name it asks for, and by what a browser says of its origin.

A browser tells from which page a request comes (Origin, Sec-Fetch-*, Referer); scripts and spreadsheets tell
nothing of that kind and go on as they always did. What is told must be one of our own pages, on every route
and for every method: also reading is not for pages of others.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final, TypeAlias

from truepose.web.door.hosts import AllowedHosts, AskedHost, asked_host

Headers: TypeAlias = Sequence[tuple[bytes, bytes]]

# Where a link on somebody else's page may lead; whatever is not here can only be asked by our own pages.
PAGES: Final = re.compile(
    r"/|/docs|/work|/hand-downs|/operator(/[^/]+)?|/diagnoses(/[^/]+)?|/corrections(/[^/]+)?|/plan(/checklist)?|/faults|/errors(/[^/]+)?"
    r"|/(?:jobs|campaigns|identifications|validations|models)/[^/]+|/(?:robots|instruments|cells)/.+"
    r"|/sessions(/[^/]+(/result|/closing|/checklist|/again)?)?|/reports(/[^/]+/[^/.]+)?"
    r"|/fleet|/bring(/[^/]+)?|/sign-in|/first-person/[^/]+|/welcome/[^/]+|/account|/not-yours|/people|/audit|/watch/[^/]+"
)
_READING: Final = frozenset({"GET", "HEAD", "OPTIONS"})
_FRAMES: Final = frozenset({"iframe", "frame", "fencedframe", "embed", "object", "portal"})
_OURS: Final = frozenset({"same-origin", "none"})  # none: typed in, or from the bookmarks
_LONGEST: Final = 100  # letters of what somebody sent, in a sentence


@dataclass(frozen=True, slots=True)
class Asked:
    """What of a request tells where it comes from."""

    method: str
    path: str
    headers: Headers

    def all(self, name: bytes) -> list[str]:
        """Return every header of that name."""
        return [value.decode("latin-1").strip() for found, value in self.headers if found == name]


@dataclass(frozen=True, slots=True)
class Welcome:
    """The request may come in; browsers know the service under this scheme."""

    scheme: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """The request may not come in."""

    status: HTTPStatus
    sentence: str


def judge(asked: Asked, hosts: AllowedHosts) -> Welcome | Refusal:
    """Return whether a request may come in."""
    if not asked.path.startswith("/"):
        return Refusal(HTTPStatus.BAD_REQUEST, "The target of the request must be a path that begins with /.")
    host = _host(asked, hosts)
    if isinstance(host, Refusal):
        return host
    refused = _upgrade(asked) or _foreign_origin(asked, hosts, host) or _foreign_fetch(asked)
    refused = refused or _unproven_change(asked, hosts, host)
    return refused or Welcome(hosts.scheme(host) or "http")


def _host(asked: Asked, hosts: AllowedHosts) -> AskedHost | Refusal:
    sent = asked.all(b"host")
    host = asked_host(sent[0]) if len(sent) == 1 else None
    if host is None:
        return Refusal(
            HTTPStatus.BAD_REQUEST, "The request must name the host that it asks, once: a name and a port."
        )
    if hosts.scheme(host) is None:
        return Refusal(
            HTTPStatus.MISDIRECTED_REQUEST,
            f"This service does not answer as {_shown(host.name)}; if that is its name or address here, "
            f"start it with --allowed-host {_shown(host.name)} (or TRUEPOSE_ALLOWED_HOSTS).",
        )
    return host


def _upgrade(asked: Asked) -> Refusal | None:
    wanted = {token.strip().lower() for value in asked.all(b"upgrade") for token in value.split(",")}
    if "websocket" not in wanted:
        return None
    return Refusal(
        HTTPStatus.BAD_REQUEST, "There are no WebSockets here; /api/v1/events streams what happens."
    )


def _foreign_origin(asked: Asked, hosts: AllowedHosts, host: AskedHost) -> Refusal | None:
    foreign = [origin for origin in asked.all(b"origin") if not hosts.is_origin(origin, host)]
    return _foreign(f"a page of {_shown(foreign[0])}") if foreign else None


def _foreign_fetch(asked: Asked) -> Refusal | None:
    if _FRAMES.intersection(asked.all(b"sec-fetch-dest")):
        return Refusal(HTTPStatus.FORBIDDEN, "Pages of this service are not shown within other pages.")
    sites = asked.all(b"sec-fetch-site")
    if _OURS.issuperset(sites) and (asked.method in _READING or "none" not in sites):
        return None
    return None if _is_link_to_page(asked) else _foreign("another page")


def _is_link_to_page(asked: Asked) -> bool:
    return (
        asked.method == "GET"
        and asked.all(b"sec-fetch-mode") == ["navigate"]
        and asked.all(b"sec-fetch-dest") == ["document"]
        and PAGES.fullmatch(asked.path) is not None
    )


def _unproven_change(asked: Asked, hosts: AllowedHosts, host: AskedHost) -> Refusal | None:
    """Return a refusal of what would change something, comes from a browser, and does not say from where."""
    if asked.method in _READING or asked.all(b"origin") or asked.all(b"sec-fetch-site"):
        return None
    referers = asked.all(b"referer")
    if any(not hosts.is_origin(_origin_of(referer), host) for referer in referers):
        return _foreign("another page")
    told = any(name == b"cookie" or name.startswith(b"sec-fetch-") for name, _ in asked.headers)
    return _foreign("a browser that does not say from which page") if told and not referers else None


def _origin_of(address: str) -> str:
    scheme, _, rest = address.partition("://")
    return f"{scheme}://{re.split('[/?#]', rest, maxsplit=1)[0]}"


def _foreign(whence: str) -> Refusal:
    return Refusal(
        HTTPStatus.FORBIDDEN,
        f"The request comes from {whence}; in a browser only the service's own pages may ask it. "
        "A proxy in front must pass on the Host that was asked.",
    )


def _shown(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
