"""Puts acts on record beside the requests: a stop must not wait for the disk to take note of it.

Within a second an act is written. Where the disk refuses, acts wait in memory, the first ones longest, and
are written once it takes records again.
"""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from itertools import islice
from typing import Final

from truepose.domain.errors import RecordRefusedError
from truepose.storage.errors import ConflictError
from truepose.storage.people import ActRepository, PersonsAct

_LOG: Final = logging.getLogger(__name__)
_WAITING: Final = 10_000  # beyond, new ones are counted only: memory is not for a flood
_TOGETHER: Final = 200


class ActLog:
    """Acts on their way to the disk."""

    def __init__(self, stored: ActRepository, writable: Callable[[], Awaitable[None]]) -> None:
        self._stored = stored
        self._writable = writable
        self._waiting: deque[PersonsAct] = deque()
        self._lost = 0
        self._closing = False
        self._noted = asyncio.Event()
        self._written = asyncio.Event()
        self._written.set()

    def note(self, act: PersonsAct) -> None:
        """Have an act be written; waits for nothing and raises nothing, as a stop passes here too."""
        if len(self._waiting) >= _WAITING:
            self._lost += 1
            return
        self._waiting.append(act)
        self._written.clear()
        self._noted.set()

    async def written(self) -> None:
        """Return once everything that was noted is on disk: while the disk refuses, not at all."""
        await self._written.wait()

    def end(self) -> None:
        """Have `follow` write what is left, and return."""
        self._closing = True
        self._noted.set()

    async def follow(self) -> None:
        """Write what is noted, until the end is asked for; one task of the service calls it."""
        while not self._closing:
            await self._noted.wait()
            try:
                await self._write()
            except RecordRefusedError:
                if not self._closing:
                    await self._writable()
        if self._waiting or self._lost:
            _LOG.error("%d acts could not be put on record", len(self._waiting) + self._lost)

    async def _write(self) -> None:
        while self._waiting:
            together = list(islice(self._waiting, _TOGETHER))
            # They leave the queue once they are on disk: what is refused is part of the next try, in its old
            # order.
            try:
                await self._stored.add(together)
            except ConflictError:
                await self._add_each(together)
            for _ in together:
                self._waiting.popleft()
        self._noted.clear()
        self._written.set()

    async def _add_each(self, together: list[PersonsAct]) -> None:
        """Keep acts one by one: one that the records do not allow must not keep the others from the disk."""
        for act in together:
            try:
                await self._stored.add([act])
            except ConflictError as error:
                _LOG.error("an act of %s could not be put on record: %s", act.operation, error)
