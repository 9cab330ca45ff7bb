"""A worker process as the service sees it: started, listened to, killed with all its children."""

import asyncio
import logging
import os
import signal
import sys
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any, Protocol, cast

from truepose.analysis.errors import AnalysisError, WorkerDiedError
from truepose.analysis.workers.pipe import (
    LENGTH_BYTES,
    Finished,
    Progressed,
    Refused,
    body_length,
    packed,
    unpacked,
)
from truepose.analysis.workers.tasks import Answer, Task
from truepose.processes import in_own_group, kill_group
from truepose.start import ONE_THREAD

_LOG = logging.getLogger(__name__)
Told = Callable[[float, str], Awaitable[None]]
_COMMAND = (sys.executable, "-m", "truepose.analysis.workers.worker")
_MODEST_BYTES = 2 * 2**30  # where the system does not say how much memory there is
_DYING_S = 2.0
_LOG_LINES = 40  # of the worker's standard error, kept for the log when it dies


class Perform(Protocol):
    """Performs a task somewhere else; cancelling it stops the work."""

    async def __call__(self, task: Task, told: Told) -> Answer:
        """Return the answer; raises TaskRefusedError or WorkerDiedError."""
        ...


class TaskRefusedError(AnalysisError):
    """The worker answered with a sentence instead of a result."""

    def __init__(self, sentence: str, code: str = "") -> None:
        super().__init__(sentence)
        self.code = code  # of the error in the worker; none: it has that of this one


async def perform_in_worker(
    task: Task, told: Told, command: tuple[str, ...] = _COMMAND, *, memory_bytes: int | None = None
) -> Answer:
    """Perform `task` in a process of its own and return its answer.

    Cancelling the coroutine kills the process and its children. `told` receives the progress. The process
    may take `memory_bytes`, by default a third of what the computer has.

    Raises
    ------
    TaskRefusedError
        The task cannot be done; the text is the worker's sentence.
    WorkerDiedError
        The process ended without an answer.
    """
    pipe = asyncio.subprocess.PIPE
    try:
        process = await asyncio.create_subprocess_exec(
            *command,
            str(memory_bytes or _a_third_of_all()),
            stdin=pipe,
            stdout=pipe,
            stderr=pipe,
            env=os.environ | ONE_THREAD,
            **in_own_group(),
        )
    except OSError as error:
        raise WorkerDiedError(
            f"No worker process could be started ({error}); nothing was stored. Free memory or processes of "
            "this computer, then start the job again."
        ) from error
    _LOG.info("worker %d has begun: %s", process.pid, type(task).__name__)
    log: deque[str] = deque(maxlen=_LOG_LINES)
    listening = asyncio.create_task(_keep_log(process, log))
    try:
        return await _converse(process, task, told)
    except (asyncio.IncompleteReadError, ConnectionError) as error:
        # The end of the pipe comes a moment before the end of the process, and of its last words.
        await asyncio.wait({asyncio.create_task(process.wait()), listening}, timeout=_DYING_S)
        raise WorkerDiedError(_obituary(process, log)) from error
    finally:
        kill_group(process)
        await process.wait()
        listening.cancel()
        _LOG.info("worker %d has ended", process.pid)


async def _converse(process: asyncio.subprocess.Process, task: Task, told: Told) -> Answer:
    if process.stdin is None or process.stdout is None:
        raise WorkerDiedError("The worker process has no pipe.")
    # Off the loop: an archive of a large campaign takes its time.
    process.stdin.write(await asyncio.to_thread(packed, task))
    await process.stdin.drain()
    while True:
        match await _next(process.stdout):
            case Progressed(fraction, doing):
                await told(fraction, doing)
            case Finished(answer):
                return cast(Answer, answer)
            case Refused(sentence, code):
                raise TaskRefusedError(sentence, code)


def _a_third_of_all() -> int:
    """Return a third of the computer's memory [bytes]: a long job, a short one and a plan may run at once."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 3
    except (AttributeError, ValueError, OSError):
        return _MODEST_BYTES


async def _next(stream: asyncio.StreamReader) -> Any:
    head = await stream.readexactly(LENGTH_BYTES)
    return await asyncio.to_thread(unpacked, await stream.readexactly(body_length(head)))


async def _keep_log(process: asyncio.subprocess.Process, log: deque[str]) -> None:
    if process.stderr is None:
        return
    async for line in process.stderr:
        log.append(line.decode(errors="replace").rstrip())
        _LOG.info("worker %d: %s", process.pid, log[-1])


def _obituary(process: asyncio.subprocess.Process, log: deque[str]) -> str:
    status = process.returncode or 0
    how = (
        f"was ended by signal {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"
    )
    last = f"; it last said: {log[-1]}" if log else ""
    return f"The worker process {how} before it answered{last}. Start the job again; nothing was stored."
