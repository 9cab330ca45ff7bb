"""Places on the workers of Dask, however many there are at the time."""

import queue
import time
from collections.abc import Callable
from concurrent.futures import CancelledError
from typing import Any, Final

import dask
from distributed import Client, Future, KilledWorker

from truepose.analysis.cluster.alike import Arithmetic, arithmetic
from truepose.analysis.cluster.cluster import lost_reply
from truepose.analysis.cluster.parts import Reply, Task
from truepose.analysis.errors import ClusterError, WorkersUnlikeError

LOOKED_S: Final = 1.0  # between two looks at who is there
_FETCHED_S: Final = 10.0  # in which an answer has come, unless it was lost with its worker
_AHEAD: Final = 3  # tasks per thread of a worker: what travels does not keep one waiting
_WITHOUT_S: Final = 120.0  # that work waits for a worker where the last one has left


class DaskPlaces:
    """The workers of a scheduler."""

    def __init__(self, client: Client, mended: str, keep: Callable[[], None] | None = None) -> None:
        """Ask the workers what they compute with.

        Parameters
        ----------
        client : Client
        mended : str
            What somebody does where no worker is left, as part of a sentence.
        keep : callable, optional
            Starts workers again that were given up.
        """
        self.client = client
        self._mended, self._keep = mended, keep
        self._alike = _alike(client)
        self._ended: queue.SimpleQueue[Future[Any]] = queue.SimpleQueue()
        self._futures: dict[Any, tuple[int, Future[Any]]] = {}  # with their numbers, by key
        self._threads, self._looked_s = 0, -LOOKED_S
        self._there_s = time.monotonic()  # when a worker was seen last

    def room(self) -> int:
        """Return how many more tasks are taken."""
        self._look()
        return max(_AHEAD * self._threads, 1) - len(self._futures)

    def begin(self, task: Task) -> None:
        """Send a task to the scheduler."""
        future = self.client.submit(_perform, task, self._alike, pure=False)
        self._futures[future.key] = task.number, future
        future.add_done_callback(self._ended.put)

    def ended(self) -> tuple[int, Reply]:
        """Wait for the next answer; the scheduler gives the task of a lost worker to another one."""
        while True:
            self._look()
            try:
                future = self._ended.get(timeout=LOOKED_S)
            except queue.Empty:
                continue
            if future.key in self._futures:  # otherwise it was given up
                reply = self._reply(future)
                return self._futures.pop(future.key)[0], reply

    def give_up(self) -> None:
        """Forget the tasks that have not ended; what a worker has begun it ends, for nobody."""
        left = [future for _, future in self._futures.values()]
        self._futures.clear()
        self.client.cancel(left, force=True)

    def _reply(self, future: Future[Any]) -> Reply:
        """Fetch an answer; one that was lost with its worker is computed again by another."""
        while future.status not in {"error", "cancelled"}:
            try:
                reply: Reply = future.result(timeout=_FETCHED_S)
            except TimeoutError:
                self._look()
            except (KilledWorker, WorkersUnlikeError, CancelledError):
                continue  # its status says so now
            else:
                return reply
        if future.status == "cancelled":
            raise _gone()
        return _of_error(future.exception())

    def _look(self) -> None:
        """See who is there, once a second; raises ClusterError where nobody has been for long."""
        now_s = time.monotonic()
        if now_s - self._looked_s < LOOKED_S:
            return
        self._looked_s = now_s
        if self._keep is not None:
            self._keep()
        self._threads = self._count_threads()
        if self._threads or not self._futures:
            self._there_s = now_s
        elif now_s - self._there_s > _WITHOUT_S:
            raise ClusterError(
                f"No worker has been left for {_WITHOUT_S:.0f} s; what came before stands. To go on, "
                f"{self._mended}, then start this command again."
            )

    def _count_threads(self) -> int:
        try:
            return sum(self.client.nthreads().values())
        except OSError as error:
            raise _gone() from error


def _perform(task: Task, expected: Arithmetic) -> Reply:
    """Perform a task on a worker, unless its bits would not be those of the others."""
    _require_alike(expected, arithmetic(), "A worker that joined")
    return task.perform()


def _of_error(found: BaseException | None) -> Reply:
    if isinstance(found, KilledWorker):
        return lost_reply(int(dask.config.get("distributed.scheduler.allowed-failures")) + 1)
    if isinstance(found, WorkersUnlikeError):
        raise found
    return Reply(None, 0.0, f"Its worker could not compute it ({type(found).__name__}: {found}).")


def _gone() -> ClusterError:
    return ClusterError(
        "The scheduler of the workers is gone or dropped what it was given; what came before stands. "
        "Start it again, then this command: it goes on from there."
    )


def _alike(client: Client) -> Arithmetic:
    """Return what the workers compute like, which is what this program computes like.

    One that is lost meanwhile, or joins later, is asked before its first part.

    Raises
    ------
    WorkersUnlikeError
        One of them does not.
    """
    own = as_one_thread(arithmetic())
    for address, found in client.run(arithmetic, on_error="return").items():
        if isinstance(found, OSError):
            continue  # it is gone
        if not isinstance(found, Arithmetic):
            raise WorkersUnlikeError(
                f"Worker {address} cannot say what it computes with ({type(found).__name__}: {found}): "
                f"install truepose {own.truepose} there."
            )
        _require_alike(own, found, f"Worker {address}")
    return own


def as_one_thread(found: Arithmetic) -> Arithmetic:
    """Return the arithmetic of a worker that is otherwise like this program."""
    return Arithmetic(found.truepose, found.python, found.numpy, found.scipy, "1", found.sample)


def _require_alike(expected: Arithmetic, found: Arithmetic, who: str) -> None:
    difference = expected.unlike(found)
    if difference:
        raise WorkersUnlikeError(
            f"{who} {difference}, or stop that worker: its results would differ from the others' in their "
            "last bits."
        )
