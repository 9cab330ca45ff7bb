"""Uploads in turn: what somebody sends from outside never takes more than a known part of the computer.

Two are received at a time and one is read, in a worker process of bounded memory; a few more wait, unread,
on their connections. Measuring goes on meanwhile: nothing of this runs on the service's own thread.
"""

import asyncio
import functools
from contextlib import AbstractAsyncContextManager
from typing import Final, cast

from truepose.analysis.job_queue.file_tasks import (
    BroughtRead,
    CampaignRead,
    CheckFileTask,
    FileChecked,
    ReadBroughtTask,
    TargetsFile,
)
from truepose.analysis.job_queue.supervisor import (
    Perform,
    TaskRefusedError,
    Turns,
    perform_in_worker,
    unheard,
)
from truepose.analysis.job_queue.tasks import Answer, ReadCampaignTask
from truepose.messages.message import message

# Four times what the largest campaign takes that the limits of `exchange` let pass.
READING_BYTES: Final = 1024 * 2**20
read_in_worker: Final = functools.partial(perform_in_worker, memory_bytes=READING_BYTES)
_AT_ONCE: Final = 2
_WAITING: Final = 4  # of the sixteen requests that the door lets in at a time
_PATIENCE_S: Final = 30.0  # most clients give up after that
_READING_S: Final = 120.0  # the largest campaign takes ten seconds


class Uploads:
    """Gives each upload its turn, and reads what it brought."""

    def __init__(self, perform: Perform = read_in_worker, patience_s: float = _PATIENCE_S) -> None:
        self._perform = perform
        self._turns = Turns(at_once=_AT_ONCE, waiting=_WAITING, patience_s=patience_s)
        self._reading = asyncio.Lock()

    def turn(self) -> AbstractAsyncContextManager[None]:
        """Wait for a turn to receive and read an upload; raises BusyError where too many wait already."""
        return self._turns.taken()

    async def read(self, archive: bytes, name: str) -> CampaignRead:
        """Return what an archive holds; cancelling it ends the worker.

        Raises
        ------
        TaskRefusedError
            It is no campaign that can be read; the sentence says why.
        WorkerDiedError
            Reading it ended the worker.
        """
        return cast(CampaignRead, await self._read(ReadCampaignTask(archive, name), "campaign"))

    async def check(self, file: TargetsFile) -> FileChecked:
        """Return what a file of targets holds, if it can be read; cancelling and errors as of `read`."""
        return cast(FileChecked, await self._read(CheckFileTask(file), "program"))

    async def look(self, task: ReadBroughtTask) -> BroughtRead:
        """Return what was understood of files that were brought; cancelling and errors as of `read`."""
        return cast(BroughtRead, await self._read(task, "campaign"))

    async def _read(self, task: ReadCampaignTask | CheckFileTask | ReadBroughtTask, kind: str) -> Answer:
        # One at a time, although two are received: each reading may take 1 GB (decision 0023).
        async with self._reading:
            try:
                async with asyncio.timeout(_READING_S):
                    return await self._perform(task, unheard)
            except TimeoutError as error:
                raise TaskRefusedError(
                    message("refused.slow_read", seconds=round(_READING_S), kind=kind)
                ) from error
