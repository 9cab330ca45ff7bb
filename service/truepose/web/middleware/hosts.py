"""Under which names the service may be asked, and the proxies whose word on who asks counts.

AddressError
├── UnusableHostError    what should be allowed is no name of a host
└── UnusableProxyError   what should be a proxy is no address, or is everybody

A page of any site can let its own name point to 127.0.0.1; to the browser the service is then a part of that
site. The name is in the request's Host, and it is not one of ours: that is how such a request is known.

A proxy tells in X-Forwarded-For from whom it has a request, behind whatever was written there before. So the
last address that is no proxy of ours is the one that one of ours has seen; what stands before it is hearsay.
"""

import functools
import ipaddress
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose.domain.errors import TrueposeError


class AddressError(TrueposeError):
    """Base of every error of allowed hosts and proxies."""


class UnusableHostError(AddressError):
    """What should be allowed is no name of a host."""


class UnusableProxyError(AddressError):
    """What should be a proxy is no address, or is everybody."""


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


def requested_host(text: str) -> AskedHost | None:
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
        origin = requested_host(rest)
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
        found = None if _ODD_ADDRESS.fullmatch(listening) else requested_host(listening)
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
            f"{text!r} cannot be an allowed host: give a name or an address as shown in a "
            "browser, without port and path, e.g. cell3.shop or 192.168.1.20, or "
            "https://cell3.shop behind a TLS proxy."
        )
    return found[1] and found[1].lower(), name


_Address: TypeAlias = ipaddress.IPv4Address | ipaddress.IPv6Address
_MOST_HOPS: Final = 10  # of proxies of ours, one behind the other


class Proxies:
    """The proxies whose word counts on who asks."""

    def __init__(self, told: Iterable[str] = ()) -> None:
        """Take the word of addresses, or of networks such as 172.18.0.0/16; raises UnusableProxyError."""
        self._networks = tuple(map(_network, told))

    def includes(self, address: str) -> bool:
        """Return whether an address is that of a proxy."""
        found = _address(address)
        return found is not None and self._is_proxy(found)

    def who_asks(self, peer: str, forwarded: Sequence[str]) -> str:
        """Return the address of whoever asks.

        Parameters
        ----------
        peer : str
            Whose connection it is.
        forwarded : sequence of str
            Every X-Forwarded-For of the request, in order. Of somebody who is no proxy it is not looked at.
        """
        hops = [hop.strip() for line in forwarded for hop in line.split(",")][-_MOST_HOPS:]
        asking = _address(peer)
        while hops and asking is not None and self._is_proxy(asking):
            told = _address(hops.pop())
            if told is None:  # nobody knows then; all of whom nobody knows share the proxy's
                break
            asking = told
        return peer if asking is None else str(asking)

    def _is_proxy(self, address: _Address) -> bool:
        return any(address.version == one.version and address in one for one in self._networks)


def _network(told: str) -> ipaddress.IPv4Network | ipaddress.IPv6Network:
    try:
        network = ipaddress.ip_network(told)
    except ValueError as error:
        raise UnusableProxyError(
            f"{told!r} cannot be a proxy ({error}); give the address from which the proxy "
            "connects, e.g. 127.0.0.1."
        ) from error
    # Whoever reaches the service could then write any address into the header, and so pass every limit by
    # address.
    if not network.prefixlen:
        raise UnusableProxyError(
            f"{told} covers every address, so any client could pretend to be another. Give the "
            "address of the proxy."
        )
    return network


@functools.lru_cache(maxsize=1024)
def _address(text: str) -> _Address | None:
    """Return an address, with a port or without; one of IPv4 in IPv6 as what it is. None for what is none."""
    bare = text[1:].partition("]")[0] if text.startswith("[") else text
    if bare.count(":") == 1:
        bare = bare.partition(":")[0]
    try:
        address = ipaddress.ip_address(bare)
    except ValueError:
        return None
    return getattr(address, "ipv4_mapped", None) or address
