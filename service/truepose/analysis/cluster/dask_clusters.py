"""Whose workers of Dask: those of a scheduler that somebody runs, or of this computer while the work lasts.

Dask's workers trade pickles: whoever reaches the scheduler can have anything computed by them. Who may is
decided by Dask's own configuration (TLS, `distributed.comm`), which holds here as for any client of it.
"""

import contextlib
import logging
import os
import time
from collections.abc import Iterator
from typing import Any, Final

import dask
from distributed import Client, LocalCluster, Security, Status

from truepose.analysis.cluster.cluster import ALLOWED_FAILURES
from truepose.analysis.cluster.dask_places import LOOKED_S, DaskPlaces
from truepose.analysis.errors import ClusterError
from truepose.start import ONE_THREAD

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
    encrypted = bool(dask.config.get("distributed.comm.require-encryption"))
    url = f"{'tls' if encrypted else 'tcp'}://{address}"
    try:
        client = Client(url, timeout=_PATIENCE_S, set_as_default=False, security=_security(encrypted))
    except (OSError, ValueError) as error:
        how = "and do both trust the other's certificate" if encrypted else "and does it do without TLS"
        raise ClusterError(
            f"No Dask scheduler answers at {url} ({error}); is it running, reachable from here, {how}?"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=_PATIENCE_S)
        except TimeoutError as error:
            raise ClusterError(
                f"The scheduler at {url} has no worker; start one: dask worker {url}"
            ) from error
        yield DaskPlaces(client, f"start one (dask worker {url})")


def _security(encrypted: bool) -> Security:
    """Return what Dask's configuration says; raises ClusterError where TLS lacks the certificate for it."""
    security = Security()
    if encrypted and security.get_connection_args("client")["ssl_context"] is None:
        raise ClusterError(
            "Dask's configuration asks for TLS and names no certificate of this command: enter ca-file, and "
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
            n_workers=0,  # one that ends while it starts would end them all: see `_Kept`
            threads_per_worker=1,
            memory_limit=1.0 / count,  # of what this computer has
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",  # any free port, reached by nobody else
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        kept = _Kept(cluster, count)
        kept.await_all(client)
        yield DaskPlaces(client, "free memory of this computer", kept.again)


class _Kept:
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
                "No worker of this computer stays alive; free memory of it, or leave `dask` out of --workers."
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
