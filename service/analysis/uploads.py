"""Uploads in turn: what somebody sends from outside never takes more than a known part of the computer.

Two are received at a time and one is read, in a worker process of bounded memory; a few more wait, unread,
on their connections. Measuring goes on meanwhile: nothing of this runs on the service's own thread.
"""

import asyncio
import contextlib
import functools
from collections.abc import AsyncIterator
from typing import Final, cast

from service.analysis.errors import BusyError
from service.analysis.jobs import Perform
from service.analysis.tasks import CampaignRead, ReadCampaignTask
from service.analysis.worker_process import TaskRefusedError, perform_in_worker

# Four times what the largest campaign takes that the limits of `exchange` let pass.
READING_BYTES: Final = 1024 * 2**20
read_in_worker: Final = functools.partial(perform_in_worker, memory_bytes=READING_BYTES)
_AT_ONCE: Final = 2
_WAITING: Final = 6
_PATIENCE_S: Final = 30.0  # most clients give up after that
_READING_S: Final = 120.0  # the largest campaign takes ten seconds


class Uploads:
    """Gives each upload its turn, and reads what it brought."""

    def __init__(self, perform: Perform = read_in_worker, patience_s: float = _PATIENCE_S) -> None:
        self._perform = perform
        self._patience_s = patience_s
        self._places = asyncio.Semaphore(_AT_ONCE)
        self._reading = asyncio.Lock()
        self._present = 0

    @contextlib.asynccontextmanager
    async def turn(self) -> AsyncIterator[None]:
        """Wait for a turn to receive and read an upload; raises BusyError where too many wait already."""
        if self._present >= _AT_ONCE + _WAITING:
            raise BusyError("Too many uploads wait already; nothing was stored, send it again later.")
        self._present += 1
        try:
            async with contextlib.AsyncExitStack() as held:
                await self._wait(held)
                yield
        finally:
            self._present -= 1

    async def _wait(self, held: contextlib.AsyncExitStack) -> None:
        try:
            async with asyncio.timeout(self._patience_s):
                await held.enter_async_context(self._places)
        except TimeoutError as error:
            raise BusyError(
                "Other uploads are still being read; nothing was stored, send it again later."
            ) from error

    async def read(self, archive: bytes, name: str) -> CampaignRead:
        """Return what an archive holds; cancelling it ends the worker.

        Raises
        ------
        TaskRefusedError
            It is no campaign that can be read; the sentence says why.
        WorkerDiedError
            Reading it ended the worker.
        """
        async with self._reading:
            try:
                async with asyncio.timeout(_READING_S):
                    answer = await self._perform(ReadCampaignTask(archive, name), _nobody)
            except TimeoutError as error:
                raise TaskRefusedError(
                    f"{name}: the archive was not read within {_READING_S:.0f} s, which no campaign takes; "
                    "nothing was stored."
                ) from error
        return cast(CampaignRead, answer)


async def _nobody(fraction: float, doing: str) -> None:
    """Take progress that nobody follows."""
