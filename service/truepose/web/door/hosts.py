"""Under which names the service may be asked.

A page of any site can let its own name point to 127.0.0.1; to the browser the service is then a part of that
site. The name is in the request's Host, and it is not one of ours: that is how such a request is known.
"""

import ipaddress
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from truepose.web.door.errors import UnusableHostError

_LOOPBACK: Final = ("localhost", "127.0.0.1", "[::1]")
_DEFAULT_PORT: Final[Mapping[str, int]] = {"http": 80, "https": 443}
_NAME: Final = r"[a-z0-9](?:[a-z0-9._-]*[a-z0-9])?|\[[0-9a-f:.]+\]"
_HOST: Final = re.compile(rf"({_NAME})(?::([0-9]{{1,5}}))?", re.ASCII | re.IGNORECASE)
_ALLOWED: Final = re.compile(rf"(?:(https?)://)?({_NAME})", re.ASCII | re.IGNORECASE)
_ODD_ADDRESS: Final = re.compile(r"[0-9.]+|0x[0-9a-f.x]*", re.ASCII | re.IGNORECASE)
_LAST_PORT: Final = 65535


@dataclass(frozen=True, slots=True)
class AskedHost:
    """What a request's Host says."""

    name: str  # lower case; an address in its shortest form, IPv6 in brackets
    port: int | None


def asked_host(text: str) -> AskedHost | None:
    """Return what a Host says; None where it is no host: with a user, a path, a dot at its end."""
    found = _HOST.fullmatch(text)
    if found is None:
        return None
    name, port = _canonical(found[1]), None if found[2] is None else int(found[2])
    if name is None or (port is not None and port > _LAST_PORT):
        return None
    return AskedHost(name, port)


class AllowedHosts:
    """The names that count as this service, each with the scheme under which browsers reach it."""

    def __init__(self, names: Iterable[str] = (), listening: str = "127.0.0.1", scheme: str = "http") -> None:
        """Allow loopback, the address that is listened to and `names`.

        Parameters
        ----------
        names : iterable of str
            Names or addresses without a port; `https://NAME` where a proxy speaks TLS for the service.
        listening : str
            Where the service was told to listen. An address that stands for all allows none.
        scheme : str
            What the service speaks itself: "https" where it has a certificate.

        Raises
        ------
        UnusableHostError
            One of `names` is none.
        """
        self._schemes: dict[str, str] = dict.fromkeys(_LOOPBACK, scheme)
        told = _told(listening)
        if told is not None:
            self._schemes[told] = scheme
        for name in names:
            spoken, known = _allowed(name)
            self._schemes[known] = spoken or scheme

    def scheme(self, host: AskedHost) -> str | None:
        """Return the scheme under which browsers know a host; None where it is not ours."""
        return self._schemes.get(host.name)

    def is_origin(self, text: str, host: AskedHost) -> bool:
        """Return whether pages of an origin are those of the host that was asked."""
        scheme = self._schemes.get(host.name)
        said, _, rest = text.partition("://")
        origin = asked_host(rest)
        if scheme is None or origin is None or said.lower() != scheme or origin.name != host.name:
            return False
        usual = _DEFAULT_PORT[scheme]
        return (origin.port or usual) == (host.port or usual)


def _canonical(name: str) -> str | None:
    """Return a name in small letters, an address in its shortest form; None for brackets around none."""
    bare = name.lower()
    if not bare.startswith("["):
        return bare
    try:
        return f"[{ipaddress.IPv6Address(bare[1:-1])}]"
    except ValueError:
        return None


def _told(listening: str) -> str | None:
    try:
        address = ipaddress.ip_address(listening)
    except ValueError:
        # "", "0" and "0x0" stand for all addresses too, and no name looks like that.
        found = None if _ODD_ADDRESS.fullmatch(listening) else asked_host(listening)
        return None if found is None or found.port is not None else found.name
    if address.is_unspecified:
        return None
    return f"[{address}]" if address.version == 6 else str(address)


def _allowed(text: str) -> tuple[str | None, str]:
    bare = f"[{text}]" if text.count(":") > 1 and not text.startswith("[") and "/" not in text else text
    found = _ALLOWED.fullmatch(bare)
    name = None if found is None else _canonical(found[2])
    if found is None or name is None:
        raise UnusableHostError(
            f"{text!r} cannot be an allowed host: give a name or an address as browsers show it, without "
            "port and path, e.g. cell3.shop or 192.168.1.20, or https://cell3.shop behind a proxy with TLS."
        )
    return found[1] and found[1].lower(), name
