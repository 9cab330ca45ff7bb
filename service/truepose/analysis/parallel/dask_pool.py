"""Workers of Dask: those of a scheduler that somebody runs, or of this computer while the work lasts.

Dask's workers trade pickles: whoever reaches the scheduler can have anything computed by them. Who may is
decided by Dask's own configuration (TLS, `distributed.comm`), which holds here as for any client of it.
"""

import contextlib
import logging
import os
import queue
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from typing import Any, Final

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, Security, Status

from truepose.analysis.errors import ClusterError, WorkersUnlikeError
from truepose.analysis.parallel.arithmetic import Arithmetic, arithmetic
from truepose.analysis.parallel.tasks import ALLOWED_FAILURES, Reply, Task, lost_reply
from truepose.start import ONE_THREAD

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
                f"There has been no worker for {_WITHOUT_S:.0f} s; results so far are kept. To continue, "
                f"{self._mended}, then run this command again."
            )

    def _count_threads(self) -> int:
        try:
            return sum(self.client.nthreads().values())
        except OSError as error:
            raise _gone() from error


def _perform(task: Task, expected: Arithmetic) -> Reply:
    """Perform a task on a worker, unless its bits would not be those of the others."""
    # On the worker, before its first part: one that joined after the work began was asked by nobody else
    # (decision 0063).
    _require_alike(expected, arithmetic(), "A worker that joined later")
    return task.perform()


def _of_error(found: BaseException | None) -> Reply:
    if isinstance(found, KilledWorker):
        return lost_reply(int(dask.config.get("distributed.scheduler.allowed-failures")) + 1)
    if isinstance(found, WorkersUnlikeError):
        raise found
    return Reply(None, 0.0, f"The worker could not compute this part ({type(found).__name__}: {found}).")


def _gone() -> ClusterError:
    return ClusterError(
        "The Dask scheduler stopped or dropped its tasks; results so far are kept. "
        "Restart it, then run this command again: it continues from there."
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
        # Lost while it was asked. If it comes back it is asked before its first part.
        if isinstance(found, OSError):
            continue  # it is gone
        if not isinstance(found, Arithmetic):
            raise WorkersUnlikeError(
                f"Worker {address} did not report its numerical environment "
                f"({type(found).__name__}: {found}): "
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


_PATIENCE_S: Final = 30.0  # for a scheduler to answer, and for its first worker
_STARTING_S: Final = 60.0  # for all workers of this computer


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
    _say_in_sentences("distributed.client")  # that it is gone, and cannot be reached again
    # Dask's own setting decides, so that a site that requires TLS is never spoken to without it.
    encrypted = bool(dask.config.get("distributed.comm.require-encryption"))
    url = f"{'tls' if encrypted else 'tcp'}://{address}"
    try:
        client = Client(url, timeout=_PATIENCE_S, set_as_default=False, security=_security(encrypted))
    except (OSError, ValueError) as error:
        how = "that each side trusts the other's certificate" if encrypted else "that it does not require TLS"
        raise ClusterError(
            f"No Dask scheduler answers at {url} ({error}). Check that it is running, that it can be reached "
            f"from here, and {how}."
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE_S)
        except TimeoutError as error:
            raise ClusterError(
                f"The Dask scheduler at {url} has no worker. Start one: dask worker {url}"
            ) from error
        yield DaskPlaces(client, f"start one (dask worker {url})")


def _security(encrypted: bool) -> Security:
    """Return what Dask's configuration says; raises ClusterError where TLS lacks the certificate for it."""
    security = Security()
    if encrypted and security.get_connection_args("client")["ssl_context"] is None:
        raise ClusterError(
            "The Dask configuration requires TLS but names no certificate for this command. Set ca-file, and "
            "cert and key of the client, under distributed.comm.tls (docs/computing.md)."
        )
    return security


@contextlib.contextmanager
def of_this_computer(count: int) -> Iterator[DaskPlaces]:
    """Offer `count` workers of Dask on this computer, reached by nobody else, for as long as it takes.

    Raises
    ------
    ClusterError
        No worker stays alive.
    """
    _say_in_sentences("tornado.application")  # that a worker ended while it started
    with (
        _environment(ONE_THREAD),
        dask.config.set({"distributed.scheduler.allowed-failures": ALLOWED_FAILURES}),
        LocalCluster(
            n_workers=0,  # one that ends while it starts would end them all: see `_LocalWorkers`
            threads_per_worker=1,
            memory_limit=1.0 / count,  # of what this computer has
            # Whoever reaches a scheduler can have anything computed by it; one that is started here is
            # reached from here alone.
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port, reached by nobody else
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        kept = _LocalWorkers(cluster, count)
        kept.await_all(client)
        yield DaskPlaces(client, "free some memory on this computer", kept.again)


class _LocalWorkers:
    """Workers of this computer, kept at their number.

    Dask starts a worker again that was lost, but gives up one that ends before it has joined for the first
    time, and one that is not back within `distributed.deploy.lost-worker-timeout`: a busy computer takes
    longer.
    """

    def __init__(self, cluster: LocalCluster, count: int) -> None:
        self._cluster = cluster
        self._count = count

    def again(self) -> None:
        """Start those that were given up."""
        for name, nanny in list(self._cluster.workers.items()):
            # Taken out first: Dask counts them as workers that it has, and would start none in their place.
            if nanny.status in (Status.closed, Status.failed):
                self._cluster.workers.pop(name, None)
        self._cluster.scale(self._count)

    def await_all(self, client: Client) -> None:
        """Wait until all are there, or those that there are by then; raises ClusterError where none is."""
        began_s = time.monotonic()
        while (found := len(client.nthreads())) < self._count:
            if time.monotonic() - began_s > _STARTING_S:
                break
            self.again()
            time.sleep(LOOKED_S / 10.0)
        if not found:
            raise ClusterError(
                "No worker stays alive on this computer. Free some memory, or do not use `dask` in --workers."
            )


def _say_in_sentences(log: str) -> None:
    """Spare whoever looks on a library's own words of what is mended here, or said."""
    logging.getLogger(log).setLevel(logging.CRITICAL)


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
