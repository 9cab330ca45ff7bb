"""Workers in processes of this computer, and which workers `--workers` means.

A process is this program itself, spoken to over its own pipe (`local_worker`).
"""

import contextlib
import os
import queue
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import IO, Final

from truepose.analysis.errors import ClusterError
from truepose.analysis.job_queue.pipe import packed, received, unpacked
from truepose.analysis.parallel.addresses import WorkerAddress, has_dask, worker_address
from truepose.analysis.parallel.tasks import ALLOWED_FAILURES, Cluster, Reply, Task, lost_reply
from truepose.start import ONE_THREAD

_COMMAND: Final = (sys.executable, "-m", "truepose.analysis.parallel.local_worker")
_AHEAD: Final = 2  # tasks that a process holds: the next one is there when it ends one


@dataclass(eq=False)
class _WorkerProcess:
    """A process and the tasks that it holds, the one under way first."""

    process: subprocess.Popen[bytes]
    answers: "queue.SimpleQueue[tuple[_WorkerProcess, bytes | None]]"  # None: it is gone
    tasks: deque[Task] = field(default_factory=deque)

    def __post_init__(self) -> None:
        # A thread, as Windows cannot wait for several pipes at once.
        self._listening = threading.Thread(target=self._listen, daemon=True)
        self._listening.start()

    def send(self, task: Task) -> None:
        self.tasks.append(task)
        try:
            # Without a buffer `write` takes what the pipe has room for, and says how much that was.
            left = memoryview(packed(task))
            while left:
                left = left[_open(self.process.stdin).write(left) :]
        except OSError:
            return  # it is gone: that is seen where its answer is waited for

    def _listen(self) -> None:
        try:
            with contextlib.suppress(EOFError, OSError):
                while True:
                    self.answers.put((self, received(_open(self.process.stdout))))
        # Also where an answer does not fit into memory: who waits for it would wait for ever.
        finally:
            self.answers.put((self, None))

    def end(self) -> None:
        # The thread ends when the pipe does, and only then is the pipe closed: a descriptor that is closed
        # under a reader may be another file by the time it is read.
        self.process.kill()
        self.process.wait()
        self._listening.join()
        for pipe in (self.process.stdin, self.process.stdout):
            _close(pipe)


class Processes:
    """So many processes, started when there is something for them to do."""

    def __init__(self, count: int, allowed_failures: int = ALLOWED_FAILURES) -> None:
        self._count = count
        self._allowed_failures = allowed_failures
        self._workers: list[_WorkerProcess] = []
        self._answers: queue.SimpleQueue[tuple[_WorkerProcess, bytes | None]] = queue.SimpleQueue()
        self._lost: dict[int, int] = {}  # times that a task lost its process, by its number

    def room(self) -> int:
        """Return how many more tasks are taken."""
        return _AHEAD * self._count - sum(len(worker.tasks) for worker in self._workers)

    def begin(self, task: Task) -> None:
        """Give a task to whoever has least to do."""
        idle = min(self._workers, key=lambda worker: len(worker.tasks), default=None)
        if idle is None or (idle.tasks and len(self._workers) < self._count):
            idle = self._started()
        idle.send(task)

    def ended(self) -> tuple[int, Reply]:
        """Wait for the next answer; a task whose process is gone goes to another one."""
        while True:
            worker, body = self._answers.get()
            if worker not in self._workers:
                continue  # of one that was given up
            if body is not None:
                return worker.tasks.popleft().number, unpacked(body)
            number = self._replaced(worker)
            if number is not None:
                return number, lost_reply(self._lost.pop(number))

    def give_up(self) -> None:
        """End the processes at once, whatever they compute."""
        for worker in list(self._workers):
            self._end(worker)

    def __enter__(self) -> "Processes":
        return self

    def __exit__(self, *_: object) -> None:
        self.give_up()

    @property
    def process_ids(self) -> tuple[int, ...]:
        """Of the processes that were started."""
        return tuple(worker.process.pid for worker in self._workers)

    def _started(self) -> _WorkerProcess:
        try:
            process = subprocess.Popen(
                _COMMAND,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                # As everywhere: other threads, other last bits (decision 0070).
                env=os.environ | ONE_THREAD,
            )
        except OSError as error:
            raise ClusterError(
                f"No worker process could be started ({error}). Free some memory or end other processes on "
                "this computer, then try again."
            ) from error
        worker = _WorkerProcess(process, self._answers)
        self._workers.append(worker)
        return worker

    def _replaced(self, worker: _WorkerProcess) -> int | None:
        """Give the tasks of a lost process to others; return the number of the one to blame, once it is."""
        self._end(worker)
        blamed = None
        # The first task was under way; the others only waited behind it, and are not to blame.
        if worker.tasks:
            first = worker.tasks[0].number
            self._lost[first] = self._lost.get(first, 0) + 1
            if self._lost[first] > self._allowed_failures:
                blamed = worker.tasks.popleft().number
        # They go to the workers that are left, or to a new one: one process is lost, never its tasks.
        for task in worker.tasks:
            self.begin(task)
        return blamed

    def _end(self, worker: _WorkerProcess) -> None:
        self._workers.remove(worker)
        worker.end()


def _open(pipe: IO[bytes] | None) -> IO[bytes]:
    if pipe is None:
        raise ClusterError("A worker process has no pipe.")
    return pipe


def _close(pipe: IO[bytes] | None) -> None:
    try:
        _open(pipe).close()
    except OSError:
        return  # what could not be sent any more is of no use to anybody


MANY: Final = 64  # parts from which on starting Dask is nothing beside them


@contextlib.contextmanager
def workers(where: str | None, parts: int) -> Iterator[Cluster]:
    """Offer the workers that somebody asked for as long as the context lasts.

    Parameters
    ----------
    where : str or None
        `dask://host:port` is a scheduler, `dask` one of this computer, a number so many processes of it.
        None takes a worker a core, on Dask where many parts wait and it is installed.
    parts : int
        That there are to compute.

    Raises
    ------
    ConfigurationError
        `where` is none of these, or Dask is not installed.
    ClusterError
        The workers cannot be reached or would not compute the same bits.
    """
    count = max(1, min(_cores(), parts))
    asked = _usual(count, parts) if where is None else worker_address(where)
    with contextlib.ExitStack() as held:
        if asked.scheduler:
            from truepose.analysis.parallel.dask_pool import of_scheduler

            yield Cluster(held.enter_context(of_scheduler(asked.scheduler)))
        elif not asked.processes:
            from truepose.analysis.parallel.dask_pool import of_this_computer

            yield Cluster(held.enter_context(of_this_computer(count)))
        else:
            yield Cluster(held.enter_context(Processes(asked.processes)))


def _usual(count: int, parts: int) -> WorkerAddress:
    return WorkerAddress() if count > 1 and parts >= MANY and has_dask() else WorkerAddress(count)


def _cores() -> int:
    """Return how many processors this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
