"""Places on Dask: a scheduler that somebody runs, or one of this computer for the length of the work.

Dask's workers trade pickles: whoever reaches the scheduler can have anything computed by them. Who may is
decided by Dask's own configuration (TLS, `distributed.comm`), which holds here as for any client of it.
"""

import contextlib
import logging
import os
import time
from collections.abc import Iterator
from typing import Any, Final

from truepose.analysis.cluster.alike import Arithmetic, arithmetic
from truepose.analysis.cluster.cluster import ALLOWED_FAILURES, lost_reply
from truepose.analysis.cluster.parts import Reply, Task
from truepose.analysis.errors import ClusterError, WorkersUnlikeError
from truepose.domain.errors import ConfigurationError
from truepose.start import ONE_THREAD

try:
    import dask
    from distributed import Client, Future, KilledWorker, LocalCluster, Security, as_completed
except ImportError as error:
    raise ConfigurationError(
        "Workers on Dask need its package, which is not installed: pip install 'truepose[dask]', or leave "
        "--workers out."
    ) from error

_AHEAD: Final = 3  # tasks per thread of a worker: what travels does not keep one waiting
_LOOKED_S: Final = 1.0  # between two looks at how many workers there are
_PATIENCE_S: Final = 30.0  # for a scheduler to answer, and for its first worker


class DaskPlaces:
    """The workers of a scheduler, however many there are at the time."""

    def __init__(self, client: "Client") -> None:
        self.client = client
        self._alike = _alike(client)
        self._ended = as_completed(loop=client.loop)
        self._futures: dict[Any, int] = {}  # numbers by key
        self._threads, self._looked_s = 0, -_LOOKED_S

    def room(self) -> int:
        """Return how many more tasks are taken."""
        if time.monotonic() - self._looked_s >= _LOOKED_S:
            self._threads = self._count_threads()
            self._looked_s = time.monotonic()
        return max(_AHEAD * self._threads, 1) - len(self._futures)

    def _count_threads(self) -> int:
        try:
            return sum(self.client.nthreads().values())
        except OSError as error:
            raise _gone() from error

    def begin(self, task: Task) -> None:
        """Send a task to the scheduler."""
        future = self.client.submit(_perform, task, self._alike, pure=False)
        self._futures[future.key] = task.number
        self._ended.add(future)

    def ended(self) -> tuple[int, Reply]:
        """Wait for the next answer; the scheduler gives the task of a lost worker to another one."""
        future = next(self._ended)
        number = self._futures.pop(future.key)
        return number, _reply(future)

    def give_up(self) -> None:
        """Forget the tasks that have not ended; what a worker has begun it ends, for nobody."""
        self.client.cancel(list(self._ended.futures), force=True)
        self._ended.clear()
        self._futures.clear()


def _perform(task: Task, expected: Arithmetic) -> Reply:
    """Perform a task on a worker, unless its bits would not be those of the others."""
    _require_alike(expected, arithmetic(), "A worker that joined")
    return task.perform()


def _reply(future: "Future[Any]") -> Reply:
    if future.status == "finished":
        reply: Reply = future.result()
        return reply
    if future.status == "cancelled":
        raise _gone()
    found = future.exception()
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


def _alike(client: "Client") -> Arithmetic:
    """Return what the workers compute like, which is what this program computes like.

    Raises
    ------
    WorkersUnlikeError
        One of them does not.
    """
    own = as_one_thread(arithmetic())
    for address, found in client.run(arithmetic, on_error="return").items():
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


@contextlib.contextmanager
def of_scheduler(address: str) -> Iterator[DaskPlaces]:
    """Offer the workers of the scheduler at `host:port`.

    Raises
    ------
    ClusterError
        Nobody answers there, or no worker has joined.
    WorkersUnlikeError
        A worker would not compute the same bits.
    """
    # That it is gone, and cannot be reached again, is said in a sentence, not in its client's own log.
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    encrypted = dask.config.get("distributed.comm.require-encryption")
    url = f"{'tls' if encrypted else 'tcp'}://{address}"
    try:
        client = Client(url, timeout=_PATIENCE_S, set_as_default=False, security=Security())
    except (OSError, ValueError) as error:
        raise ClusterError(
            f"No Dask scheduler answers at {url} ({error}); is it running, and reachable from here?"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE_S)
        except TimeoutError as error:
            raise ClusterError(
                f"The scheduler at {url} has no worker; start one: dask worker {url}"
            ) from error
        yield DaskPlaces(client)


@contextlib.contextmanager
def of_this_computer(count: int) -> Iterator[DaskPlaces]:
    """Offer `count` workers of Dask on this computer, reached by nobody else, for as long as it takes."""
    with (
        _environment(ONE_THREAD),
        dask.config.set({"distributed.scheduler.allowed-failures": ALLOWED_FAILURES}),
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port, reached by nobody else
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield DaskPlaces(client)


@contextlib.contextmanager
def _environment(values: dict[str, str]) -> Iterator[None]:
    """Let processes that are started meanwhile inherit some variables."""
    before: dict[str, Any] = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})
