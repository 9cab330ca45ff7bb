"""Places in processes of this computer, one task after the other in each.

A process is this program itself, spoken to over its own pipe (`lane`).
"""

import os
import queue
import subprocess
import sys
import threading
from collections import deque
from dataclasses import dataclass, field
from typing import IO, Final

from truepose.analysis.cluster.cluster import ALLOWED_FAILURES, lost_reply
from truepose.analysis.cluster.parts import Reply, Task
from truepose.analysis.errors import ClusterError
from truepose.analysis.workers.pipe import packed, received, unpacked
from truepose.start import ONE_THREAD

_COMMAND: Final = (sys.executable, "-m", "truepose.analysis.cluster.lane")
_AHEAD: Final = 2  # tasks that a process holds: the next one is there when it ends one


@dataclass(eq=False)
class _Lane:
    """A process and the tasks that it holds, the one under way first."""

    process: subprocess.Popen[bytes]
    answers: "queue.SimpleQueue[tuple[_Lane, bytes | None]]"  # None: it is gone
    tasks: deque[Task] = field(default_factory=deque)

    def __post_init__(self) -> None:
        # A thread, as Windows cannot wait for several pipes at once.
        self._listening = threading.Thread(target=self._listen, daemon=True)
        self._listening.start()

    def send(self, task: Task) -> None:
        self.tasks.append(task)
        try:
            left = memoryview(packed(task))
            while left:
                left = left[_open(self.process.stdin).write(left) :]
        except OSError:
            return  # it is gone: that is seen where its answer is waited for

    def _listen(self) -> None:
        try:
            while True:
                self.answers.put((self, received(_open(self.process.stdout))))
        except (EOFError, OSError):
            self.answers.put((self, None))

    def end(self) -> None:
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
        self._lanes: list[_Lane] = []
        self._answers: queue.SimpleQueue[tuple[_Lane, bytes | None]] = queue.SimpleQueue()
        self._lost: dict[int, int] = {}  # times that a task lost its process, by its number

    def room(self) -> int:
        """Return how many more tasks are taken."""
        return _AHEAD * self._count - sum(len(lane.tasks) for lane in self._lanes)

    def begin(self, task: Task) -> None:
        """Give a task to whoever has least to do."""
        idle = min(self._lanes, key=lambda lane: len(lane.tasks), default=None)
        if idle is None or (idle.tasks and len(self._lanes) < self._count):
            idle = self._started()
        idle.send(task)

    def ended(self) -> tuple[int, Reply]:
        """Wait for the next answer; a task whose process is gone goes to another one."""
        while True:
            lane, body = self._answers.get()
            if lane not in self._lanes:
                continue  # of one that was given up
            if body is not None:
                return lane.tasks.popleft().number, unpacked(body)
            number = self._replaced(lane)
            if number is not None:
                return number, lost_reply(self._lost.pop(number))

    def give_up(self) -> None:
        """End the processes at once, whatever they compute."""
        for lane in list(self._lanes):
            self._end(lane)

    def __enter__(self) -> "Processes":
        return self

    def __exit__(self, *_: object) -> None:
        self.give_up()

    @property
    def process_ids(self) -> tuple[int, ...]:
        """Of the processes that were started."""
        return tuple(lane.process.pid for lane in self._lanes)

    def _started(self) -> _Lane:
        try:
            process = subprocess.Popen(
                _COMMAND,
                bufsize=0,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env=os.environ | ONE_THREAD,
            )
        except OSError as error:
            raise ClusterError(
                f"No worker process could be started ({error}); free memory or processes of this computer, "
                "then start it again."
            ) from error
        lane = _Lane(process, self._answers)
        self._lanes.append(lane)
        return lane

    def _replaced(self, lane: _Lane) -> int | None:
        """Give the tasks of a lost process to others; return the number of the one to blame, once it is."""
        self._end(lane)
        blamed = None
        if lane.tasks:
            first = lane.tasks[0].number
            self._lost[first] = self._lost.get(first, 0) + 1
            if self._lost[first] > self._allowed_failures:
                blamed = lane.tasks.popleft().number
        for task in lane.tasks:
            self.begin(task)
        return blamed

    def _end(self, lane: _Lane) -> None:
        self._lanes.remove(lane)
        lane.end()


def _open(pipe: IO[bytes] | None) -> IO[bytes]:
    if pipe is None:
        raise ClusterError("A worker process has no pipe.")
    return pipe


def _close(pipe: IO[bytes] | None) -> None:
    try:
        _open(pipe).close()
    except OSError:
        return  # what could not be sent any more is of no use to anybody
