"""Which workers `--workers` means."""

import contextlib
import os
from collections.abc import Iterator
from importlib.util import find_spec
from typing import Final

from truepose.analysis.cluster.cluster import Cluster
from truepose.analysis.cluster.processes import Processes
from truepose.domain.errors import ConfigurationError

MANY: Final = 64  # parts from which on starting Dask is nothing beside them
_SCHEME: Final = "dask://"


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
    with contextlib.ExitStack() as held:
        if where is not None and where.startswith(_SCHEME):
            _require_dask()
            from truepose.analysis.cluster.dask_clusters import of_scheduler

            yield Cluster(held.enter_context(of_scheduler(_address(where))))
        elif where == "dask" or (where is None and _is_worth_dask(parts, count)):
            _require_dask()
            from truepose.analysis.cluster.dask_clusters import of_this_computer

            yield Cluster(held.enter_context(of_this_computer(count)))
        else:
            yield Cluster(held.enter_context(Processes(count if where is None else _number(where))))


def _is_worth_dask(parts: int, count: int) -> bool:
    return count > 1 and parts >= MANY and _has_dask()


def _has_dask() -> bool:
    return find_spec("distributed") is not None


def _require_dask() -> None:
    if not _has_dask():
        raise ConfigurationError(
            "Workers on Dask need its package, which is not installed: pip install 'truepose[dask]', or "
            "leave --workers out."
        )


def _address(where: str) -> str:
    address = where.removeprefix(_SCHEME).rstrip("/")
    host, _, port = address.rpartition(":")
    if not host or not port.isdecimal():
        raise _misunderstood(where)
    return address


def _number(where: str) -> int:
    if not where.isdecimal() or not 1 <= int(where) <= 1024:
        raise _misunderstood(where)
    return int(where)


def _misunderstood(where: str) -> ConfigurationError:
    return ConfigurationError(
        f"--workers {where}: give a number of processes, `dask` for Dask on this computer, or "
        "dask://host:port of its scheduler."
    )


def _cores() -> int:
    """Return how many processors this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
