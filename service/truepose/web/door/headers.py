"""What every answer tells a browser: who may show it, what may run in it, that nobody else reads it."""

from collections.abc import Iterable
from typing import Final, TypeAlias

from truepose.web.requests.pressed import TIME_HEADER, time_s

RawHeaders: TypeAlias = list[tuple[bytes, bytes]]

_NOTHING: Final = b"default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_PAGE: Final = (
    b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    b"base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_ALWAYS: Final[RawHeaders] = [
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    # A tablet stays awake while somebody measures; of its other senses the pages need none.
    (
        b"permissions-policy",
        b"screen-wake-lock=(self), fullscreen=(self), camera=(), microphone=(), geolocation=(), "
        b"display-capture=(), payment=(), usb=(), serial=(), hid=(), midi=()",
    ),
]
_POLICY: Final = b"content-security-policy"
_CACHE: Final = b"cache-control"


def with_protection(headers: Iterable[tuple[bytes, bytes]]) -> RawHeaders:
    """Return the headers of an answer with those that every answer has.

    What an answer says of its keeping stands; else it is kept nowhere, as it is old a moment later.
    """
    given = [(name.lower(), value) for name, value in headers]
    named = dict(given)
    fixed = dict(_ALWAYS)
    fixed[_POLICY] = _PAGE if named.get(b"content-type", b"").startswith(b"text/html") else _NOTHING
    kept = [(name, value) for name, value in given if name not in fixed]
    missing = [] if _CACHE in named else [(_CACHE, b"no-store")]
    return [*kept, *fixed.items(), *missing, (TIME_HEADER, b"%.3f" % time_s())]
