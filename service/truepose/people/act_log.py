"""Puts acts on record beside the requests: a stop must not wait for the disk to take note of it.

Within a second an act is written. Where the disk refuses, acts wait in memory, the first ones longest, and
are written once it takes records again.
"""

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from itertools import islice
from typing import Final

from truepose.domain.errors import RecordRefusedError, text_of
from truepose.messages.message import Text, message
from truepose.people.errors import ActsUnwrittenError
from truepose.storage.errors import ConflictError
from truepose.storage.people import ActRepository, PersonsAct

_LOG: Final = logging.getLogger(__name__)
_WAITING: Final = 10_000  # beyond, new ones are counted only: memory is not for a flood
_TOGETHER: Final = 200
_SLOW: Final = message("people.slow_disk")
PATIENCE_S: Final = 2.0  # of whoever reads what is on record, and of the end of the service


class ActLog:
    """Acts on their way to the disk."""

    def __init__(self, stored: ActRepository, writable: Callable[[], Awaitable[None]]) -> None:
        self._stored = stored
        self._writable = writable
        self._waiting: deque[PersonsAct] = deque()
        self._lost = 0
        self._refused: Text | None = None  # why the disk takes none at present
        self._ending = asyncio.Event()
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
        """Return once everything that was noted is on disk.

        Raises
        ------
        ActsUnwrittenError
            The disk refuses, or takes longer than a reader waits.
        """
        if self._refused is None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(PATIENCE_S):
                    await self._written.wait()
        if not self._written.is_set():
            raise ActsUnwrittenError(self._refused or _SLOW)

    def end(self) -> None:
        """Have `follow` write what is left, as far as the disk takes it, and return."""
        self._ending.set()
        self._noted.set()

    async def follow(self) -> None:
        """Write what is noted, until the end is asked for; one task of the service calls it."""
        try:
            while not self._ending.is_set():
                await self._noted.wait()
                try:
                    await self._write()
                except RecordRefusedError as error:
                    await self._wait_for_disk(text_of(error))
        finally:
            if self._waiting or self._lost:
                _LOG.error("%d actions could not be recorded", len(self._waiting) + self._lost)

    async def _wait_for_disk(self, why: Text) -> None:
        """Return once the disk may take records again, or the end is asked for: a full one delays no end."""
        self._refused = why
        waits = [asyncio.ensure_future(wait) for wait in (self._writable(), self._ending.wait())]
        try:
            await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._refused = None
            for wait in waits:
                wait.cancel()

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
                _LOG.error("an action of %s could not be recorded: %s", act.operation, error)
