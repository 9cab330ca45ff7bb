"""Which workers `--workers` means."""

import contextlib
import os
from collections.abc import Iterator
from typing import Final

from truepose.analysis.cluster.cluster import Cluster
from truepose.analysis.cluster.named import Named, has_dask, named
from truepose.analysis.cluster.processes import Processes

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
    asked = _usual(count, parts) if where is None else named(where)
    with contextlib.ExitStack() as held:
        if asked.scheduler:
            from truepose.analysis.cluster.dask_clusters import of_scheduler

            yield Cluster(held.enter_context(of_scheduler(asked.scheduler)))
        elif not asked.processes:
            from truepose.analysis.cluster.dask_clusters import of_this_computer

            yield Cluster(held.enter_context(of_this_computer(count)))
        else:
            yield Cluster(held.enter_context(Processes(asked.processes)))


def _usual(count: int, parts: int) -> Named:
    return Named() if count > 1 and parts >= MANY and has_dask() else Named(count)


def _cores() -> int:
    """Return how many processors this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
