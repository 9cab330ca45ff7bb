"""The census of connections and what they wait for, their pace, and descriptors that are left.

Who has sent no whole request yet can be closed without harm; so newcomers always get in: where there are too
many, the oldest of those go, of the peer that has most. A request under way is never closed to make room.

A process that has no descriptors left can neither accept a connection nor open its database, a serial port or
a worker. Beyond number 1023 `select` cannot wait for a descriptor, and pyserial waits with it: so all stay
below.
"""

import asyncio
import contextlib
import ipaddress
import logging
import sys
from collections import Counter
from collections.abc import AsyncIterator, Callable, Collection
from dataclasses import dataclass
from typing import Any, Final, Protocol

_LOG: Final = logging.getLogger(__name__)
_LOOK_S: Final = 0.5
_TELL_S: Final = 10.0
_WORTH_TELLING: Final = 10  # closed within that time; a browser now and then opens one that it does not use
_SHARE: Final = 16  # of all: so many are closed at once, so that a flood of newcomers costs little each


@dataclass(frozen=True, slots=True)
class Limits:
    """What connections may be and do."""

    connections: int
    per_peer: int = 256  # of another computer
    head_s: float = 8.0  # until the head of a request is complete
    body_s: float = 300.0  # until its body is
    body_bytes_per_s: float = 16 * 1024
    body_grace_s: float = 5.0
    answer_bytes_per_s: float = 4 * 1024
    answer_grace_s: float = 15.0


class Connection(Protocol):
    """What the census knows of a connection."""

    @property
    def peer(self) -> str:
        """Address of the other side."""

    def incomplete_since(self) -> float | None:
        """Since when a request is waited for [s]; None while one is under way."""

    def too_slow(self, now_s: float) -> str | None:
        """Say why the connection has to be closed; None where it has not."""

    def cut(self) -> None:
        """Close at once."""


class Census:
    """Counts connections and closes those that are too many or too slow."""

    def __init__(self, limits: Limits, is_proxy: Callable[[str], bool] = lambda peer: False) -> None:
        self.limits = limits
        self._is_proxy = is_proxy  # brings everybody, as loopback may
        self._all: set[Connection] = set()
        self._of_peer: Counter[str] = Counter()
        self._closed: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._all)

    def admit(self, newcomer: Connection) -> None:
        """Take a connection up, closing others or it where there are too many."""
        self._all.add(newcomer)
        self._of_peer[newcomer.peer] += 1
        if self._of_peer[newcomer.peer] > self.limits.per_peer and not self._is_shared(newcomer.peer):
            own = [connection for connection in self._all if connection.peer == newcomer.peer]
            self._make_room(own, newcomer)
        elif len(self._all) > self.limits.connections:
            self._make_room(self._all, newcomer)

    def _is_shared(self, peer: str) -> bool:
        return _is_loopback(peer) or self._is_proxy(peer)

    def leave(self, connection: Connection) -> None:
        """Forget a connection; one that is not known is none."""
        if connection in self._all:
            self._all.remove(connection)
            self._of_peer[connection.peer] -= 1
            if not self._of_peer[connection.peer]:
                del self._of_peer[connection.peer]

    def look(self, now_s: float) -> None:
        """Close every connection that is too slow."""
        for connection in list(self._all):
            reason = connection.too_slow(now_s)
            if reason is not None:
                self._cut(connection, reason)

    def out_of_descriptors(self) -> None:
        """Close some where the system gives no more: others in this process took what was counted on."""
        self._make_room(self._all, None)

    def take_closed(self) -> Counter[str]:
        """Return how many were closed for which reason since this was last asked."""
        closed, self._closed = self._closed, Counter()
        return closed

    def _make_room(self, among: Collection[Connection], newcomer: Connection | None) -> None:
        waiting = [
            (-self._of_peer[connection.peer], since_s, connection)
            for connection in among
            if connection is not newcomer and (since_s := connection.incomplete_since()) is not None
        ]
        if not waiting and newcomer is not None:
            self._cut(newcomer, "arrived while all others were busy")
        waiting.sort(key=lambda entry: entry[:2])
        for _, _, connection in waiting[: max(1, len(among) // _SHARE)]:
            self._cut(connection, "had waited longest when there were too many")

    def _cut(self, connection: Connection, reason: str) -> None:
        self._closed[reason] += 1
        self.leave(connection)
        connection.cut()


def _is_loopback(peer: str) -> bool:
    try:
        return ipaddress.ip_address(peer).is_loopback
    except ValueError:
        return False


@contextlib.asynccontextmanager
async def close_slow_connections(census: Census) -> AsyncIterator[None]:
    """Close slow connections as long as the context lasts, and say so in a line now and then."""
    loop = asyncio.get_running_loop()
    loop.set_exception_handler(lambda loop, context: _on_exception(census, loop, context))
    looking = asyncio.create_task(_keep_looking(census))
    try:
        yield
    finally:
        looking.cancel()
        loop.set_exception_handler(None)
        await asyncio.gather(looking, return_exceptions=True)


async def _keep_looking(census: Census) -> None:
    told_s = -_TELL_S
    closed: Counter[str] = Counter()
    now_s = asyncio.get_running_loop().time
    while True:
        await asyncio.sleep(_LOOK_S)
        census.look(now_s())
        closed += census.take_closed()
        if now_s() - told_s >= _TELL_S:
            _tell(closed, len(census))
            closed, told_s = Counter(), now_s()


def _tell(closed: Counter[str], left: int) -> None:
    if closed.total() >= _WORTH_TELLING:
        reasons = "; ".join(f"{count} {reason}" for reason, count in closed.most_common())
        _LOG.warning("Closed %d connections: %s. %d are open.", closed.total(), reasons, left)


def _on_exception(census: Census, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    # asyncio tells of it by this text alone: it catches the error itself and tries again after a second.
    if context.get("message", "").startswith("socket.accept() out of system resource"):
        census.out_of_descriptors()
    else:
        loop.default_exception_handler(context)


class Pace:
    """So many bytes a second after a grace, on average since it began."""

    def __init__(self, bytes_per_s: float, grace_s: float) -> None:
        self._bytes_per_s = bytes_per_s
        self._grace_s = grace_s
        self._moved = 0
        self.amount = 0  # what there is to move, where that is known
        self.since_s = 0.0

    def begin(self, now_s: float, amount: int = 0) -> None:
        """Count anew from now on."""
        self.since_s, self.amount, self._moved = now_s, amount, 0

    def move(self, n_bytes: int) -> None:
        """Count what has moved."""
        self._moved += n_bytes

    def lasted(self, now_s: float) -> float:
        """Return since how long it goes on [s]."""
        return now_s - self.since_s

    def is_behind(self, now_s: float) -> bool:
        """Return whether less has moved than should have, without any grace."""
        return self._moved < self.lasted(now_s) * self._bytes_per_s

    def too_slow(self, now_s: float, moved: int | None = None) -> bool:
        """Return whether less has moved than should have."""
        late_s = self.lasted(now_s) - self._grace_s
        return late_s > 0 and (self._moved if moved is None else moved) < late_s * self._bytes_per_s


_SELECTABLE: Final = 1024
_OWN: Final = 256  # database, devices, simulated cell, workers, and connections that are about to be closed
_OWN_SHARE: Final = 4


def connection_limit() -> int:
    """Raise this process's limit as far as is of use, and return how many connections fit into it."""
    files = _SELECTABLE if sys.platform == "win32" else _raised_limit()
    return files - min(_OWN, files // _OWN_SHARE)


if sys.platform != "win32":
    import resource

    def _raised_limit() -> int:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        most = _SELECTABLE if hard == resource.RLIM_INFINITY else min(_SELECTABLE, hard)
        if soft != resource.RLIM_INFINITY and soft < most:
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
        return most
