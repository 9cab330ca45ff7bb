"""Interpreters that have everything loaded when they begin: forked from one that has.

To load what a service needs takes a second and more. This is for tests of what a process does once it runs.
What one loads by itself, and what it says of how it was started, is tested where users start it:
`tests/system/simulators/test_process.py`, `tests/thorough/system/demo`, `tests/integration/test_serve.py`,
`tests/integration/analysis/test_worker_process.py`.
"""

import asyncio
import contextlib
import multiprocessing
import os
import runpy
import signal
import sys
from multiprocessing.connection import Connection
from subprocess import DEVNULL, PIPE

_FORKS = multiprocessing.get_context("forkserver")
_LOADED = [
    "truepose.cli",
    "truepose.app.composition",
    "truepose.analysis.job_queue.worker",
    "truepose_simulators.__main__",
]
_LINE_BYTES = 1 << 16  # of a stream, by default
_exec = asyncio.create_subprocess_exec


async def forked(
    *command,
    stdin=None,
    stdout=None,
    stderr=None,
    start_new_session=False,
    cwd=None,
    env=None,
    limit=_LINE_BYTES,
):
    """Start `sys.executable` with `-m MODULE` or `-c CODE` as `asyncio.create_subprocess_exec` does.

    What the process starts in turn by that function begins likewise. Any other command is started as ever.
    """
    program, *arguments = map(str, command)
    if program != sys.executable or arguments[0] not in {"-m", "-c"}:
        given = {"stdin": stdin, "stdout": stdout, "stderr": stderr, "cwd": cwd, "env": env}
        return await _exec(*command, **given, start_new_session=start_new_session, limit=limit)
    ends = [_Ends(number, asked) for number, asked in enumerate((stdin, stdout, stderr))]
    given = (arguments, dict(env or os.environ), cwd or os.getcwd(), start_new_session)
    _FORKS.set_forkserver_preload(_LOADED)  # of the first that is started in this process
    process = _FORKS.Process(target=_become, args=(*given, [end.of_process for end in ends]))
    await _begun(process, ends)
    for end in ends:
        end.of_process.close()
    return Forked(process, *await _streams(ends, limit))


async def _begun(process, ends):
    """Start a process, which is ended where whoever starts it gives up meanwhile."""
    starting = asyncio.create_task(asyncio.to_thread(process.start))
    try:
        await asyncio.shield(starting)
    except asyncio.CancelledError:
        await starting
        process.kill()  # else this interpreter would wait for it at its own end
        for end in ends:
            end.close()
        raise


async def _streams(ends, limit):
    """Return the streams at the other ends; none is left open where whoever starts the process gives up."""
    streams = []
    try:
        for end in ends:
            streams.append(await end.stream(limit))
    except asyncio.CancelledError:
        for _, pipe in streams:
            if pipe is not None:
                pipe.close()
        raise
    return streams


@contextlib.contextmanager
def everything_forked():
    """Within it, whatever is started by `asyncio.create_subprocess_exec` begins so."""
    asyncio.create_subprocess_exec = forked
    try:
        yield
    finally:
        asyncio.create_subprocess_exec = _exec


class Forked:
    """A process that was forked, as `asyncio.subprocess.Process` shows one."""

    def __init__(self, process, stdin, stdout, stderr):
        self._process = process
        self.stdin, self.stdout, self.stderr = (stream for stream, _ in (stdin, stdout, stderr))
        self._pipes = [pipe for _, pipe in (stdin, stdout, stderr) if pipe is not None]

    @property
    def pid(self):
        return self._process.pid

    @property
    def returncode(self):
        return self._process.exitcode

    def send_signal(self, number):
        os.kill(self.pid, number)

    def terminate(self):
        self.send_signal(signal.SIGTERM)

    def kill(self):
        self.send_signal(signal.SIGKILL)

    async def communicate(self):
        """Return what the process says until it ends; for one that is told nothing."""
        said = await self.stdout.read()
        await self.wait()
        return said, None

    async def wait(self):
        await asyncio.to_thread(self._process.join)
        for pipe in self._pipes:
            pipe.close()
        return self.returncode


class _Ends:
    """Both ends of one of the three standard streams; the other one is there where a pipe was asked for."""

    def __init__(self, number, asked):
        self._number, self._other = number, None
        if asked == PIPE:
            read, write = os.pipe()
            mine, self._other = (read, write) if number == 0 else (write, read)
        elif asked == DEVNULL:
            mine = os.open(os.devnull, os.O_RDWR)
        else:
            mine = os.dup(number if asked is None else asked if isinstance(asked, int) else asked.fileno())
        self.of_process = Connection(mine)  # a descriptor that can be handed to another process

    def close(self):
        self.of_process.close()
        if self._other is not None:
            os.close(self._other)

    async def stream(self, limit):
        """Return the stream at the other end, and what closes it."""
        if self._other is None:
            return None, None
        loop = asyncio.get_running_loop()
        if self._number == 0:
            pipe, flow = await loop.connect_write_pipe(
                asyncio.streams.FlowControlMixin, os.fdopen(self._other, "wb")
            )
            return asyncio.StreamWriter(pipe, flow, None, loop), pipe
        lines = asyncio.StreamReader(limit)
        pipe, _ = await loop.connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(lines), os.fdopen(self._other, "rb")
        )
        return lines, pipe


def _become(arguments, environment, folder, start_new_session, streams):
    if start_new_session:
        os.setsid()
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    for number, stream in enumerate(streams):
        os.dup2(stream.fileno(), number)
        stream.close()
    sys.stdin = os.fdopen(0, closefd=False)  # multiprocessing has none
    # The streams of the parent know whether theirs could be searched, which these may not.
    sys.stdout, sys.stderr = (os.fdopen(number, "w", closefd=False) for number in (1, 2))
    asyncio.create_subprocess_exec = forked
    how, what, *sys.argv[1:] = arguments
    if how == "-c":
        sys.modules.pop("truepose_simulators.__main__", None)
        exec(compile(what, "<string>", "exec"), {"__name__": "__main__"})
    else:
        for loaded in (what, f"{what}.__main__"):
            sys.modules.pop(loaded, None)
        runpy.run_module(what, run_name="__main__", alter_sys=True)
