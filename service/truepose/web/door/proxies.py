"""Who asks where a proxy stands in front: its word on that counts, and nobody else's.

A proxy tells in X-Forwarded-For from whom it has a request, behind whatever was written there before. So the
last address that is no proxy of ours is the one that one of ours has seen; what stands before it is hearsay.
"""

import functools
import ipaddress
from collections.abc import Iterable, Sequence
from typing import Final, TypeAlias

from truepose.web.door.errors import UnusableProxyError

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
            f"{told!r} cannot be a proxy ({error}); give the address that it asks from, e.g. 127.0.0.1."
        ) from error
    if not network.prefixlen:
        raise UnusableProxyError(f"{told} is everybody, and anybody could say then who they are.")
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
