"""A worker process as the service sees it: waited for in turn, started, listened to, killed."""

import asyncio
import contextlib
import logging
import os
import signal
import sys
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any, Protocol, cast

from truepose.analysis.errors import AnalysisError, BusyError, WorkerDiedError
from truepose.analysis.job_queue.pipe import (
    LENGTH_BYTES,
    TaskAnswer,
    TaskProgress,
    TaskRefusal,
    body_length,
    packed,
    unpacked,
)
from truepose.analysis.job_queue.tasks import Answer, Task
from truepose.messages.message import Message, Text, message
from truepose.processes import in_own_group, kill_group
from truepose.start import ONE_THREAD


class Turns:
    """Lets `at_once` in, lets `waiting` wait for at most `patience_s`, and sends all others away."""

    def __init__(self, *, at_once: int, waiting: int, patience_s: float) -> None:
        self._most = at_once + waiting
        self._patience_s = patience_s
        self._places = asyncio.Semaphore(at_once)
        self._present = 0

    @contextlib.asynccontextmanager
    async def taken(self) -> AsyncIterator[None]:
        """Wait for a turn and hold it; raises BusyError."""
        # Before any wait: whoever is one too many is told at once when to come back, and holds no connection.
        if self._present >= self._most:
            raise BusyError(message("refused.busy"))
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
            raise BusyError(message("refused.busy")) from error


_LOG = logging.getLogger(__name__)
Told = Callable[[float, Text], Awaitable[None]]
_COMMAND = (sys.executable, "-m", "truepose.analysis.job_queue.worker")
_MODEST_BYTES = 2 * 2**30  # where the system does not say how much memory there is
_DYING_S = 2.0
_LOG_LINES = 40  # of the worker's standard error, kept for the log when it dies
_LOG_CHARACTERS = 500  # of a line


async def unheard(_fraction: float, _doing: Text) -> None:
    """Let progress be told to nobody."""


class Perform(Protocol):
    """Performs a task somewhere else; cancelling it stops the work."""

    async def __call__(self, task: Task, told: Told) -> Answer:
        """Return the answer; raises TaskRefusedError or WorkerDiedError."""
        ...


class TaskRefusedError(AnalysisError):
    """The worker answered with a sentence instead of a result."""

    def __init__(self, sentence: Text, code: str = "") -> None:
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
            # The last bits of a result would follow from the number of threads, and so from the computer
            # (decision 0070).
            env=os.environ | ONE_THREAD,
            # Ctrl-C at a terminal asks the service to end, which ends its workers itself; what a worker
            # starts is killed with its group.
            **in_own_group(),
        )
    except OSError as error:
        raise WorkerDiedError(message("job.no_process", why=str(error))) from error
    _LOG.info("worker %d started: %s", process.pid, type(task).__name__)
    log: deque[str] = deque(maxlen=_LOG_LINES)
    listening = asyncio.create_task(_keep_log(process, log))
    try:
        return await _converse(process, task, told)
    except (asyncio.IncompleteReadError, ConnectionError) as error:
        # The end of the pipe comes a moment before the end of the process, and of its last words.
        await asyncio.wait({asyncio.create_task(process.wait()), listening}, timeout=_DYING_S)
        raise WorkerDiedError(_obituary(process, log)) from error
    finally:
        # Whatever ended the conversation, a cancellation included: no process outlives it.
        kill_group(process)
        listening.cancel()
        await asyncio.wait({listening})
        await _drained(process)
        _LOG.info("worker %d ended", process.pid)


async def _converse(process: asyncio.subprocess.Process, task: Task, told: Told) -> Answer:
    if process.stdin is None or process.stdout is None:
        raise WorkerDiedError(message("job.no_pipe"))
    # Off the loop: an archive of a large campaign takes its time.
    process.stdin.write(await asyncio.to_thread(packed, task))
    await process.stdin.drain()
    while True:
        match await _next(process.stdout):
            case TaskProgress(fraction, doing):
                await told(fraction, doing)
            case TaskAnswer(answer):
                return cast(Answer, answer)
            case TaskRefusal(sentence, code):
                raise TaskRefusedError(sentence, code)


def _a_third_of_all() -> int:
    """Return a third of the computer's memory [bytes]: a long job, a short one and a plan may run at once."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 3
    except (AttributeError, ValueError, OSError):
        return _MODEST_BYTES


async def _next(stream: asyncio.StreamReader) -> Any:
    # Off the loop as well: an answer is as large as the question, and a session under way would wait for it.
    head = await stream.readexactly(LENGTH_BYTES)
    return await asyncio.to_thread(unpacked, await stream.readexactly(body_length(head)))


async def _keep_log(process: asyncio.subprocess.Process, log: deque[str]) -> None:
    if process.stderr is None:
        return
    # Read to the end, though hardly anybody looks: a pipe that is full stops whoever writes into it.
    while line := await _next_line(process.stderr):
        log.append(line.decode(errors="replace").rstrip()[-_LOG_CHARACTERS:])
        _LOG.info("worker %d: %s", process.pid, log[-1])


async def _next_line(stream: asyncio.StreamReader) -> bytes:
    while True:
        # What is longer than the stream's limit is dropped by it: of such a line comes the end.
        with contextlib.suppress(ValueError):
            return await stream.readline()


async def _drained(process: asyncio.subprocess.Process) -> None:
    """Read what a killed process left in its pipes, for nobody: its end is not known before theirs."""
    # With a limit: what left the group of the process may hold its pipes for ever.
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(_DYING_S):
            await process.communicate()


def _obituary(process: asyncio.subprocess.Process, log: deque[str]) -> Message:
    status = process.returncode or 0
    how = message("job.worker.status", status=status)
    if status < 0:
        how = message("job.worker.signal", signal=_signal_name(-status))
    if not log:
        return message("job.worker.died", how=how)
    return message("job.worker.died.said", how=how, last=log[-1])


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # real-time signals between the first and the last have none
        return str(number)
