"""A database that refuses, brought about from outside: by its files, its locks, and the process's limits."""

import contextlib
import resource
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from random import Random

from truepose.storage.engine.sqlite_connections import LIBRARY

_SHORT_S = 10.0  # what is no lock lasts no longer
_TURN_S = 30.0  # until a commit that is under way leaves the lock to others
_PART_OF_A_PAGE = 2000  # bytes: a page is torn where the room ends


@contextlib.contextmanager
def _growing_to(pid: int, most_bytes: int) -> Iterator[None]:
    """Have no file of a process grow beyond so much; a write that begins below is cut short there."""
    before = resource.prlimit(pid, resource.RLIMIT_FSIZE)
    resource.prlimit(pid, resource.RLIMIT_FSIZE, (most_bytes, before[1]))
    try:
        yield
    finally:
        resource.prlimit(pid, resource.RLIMIT_FSIZE, before)


def _no_room(file: Path, pid: int) -> AbstractContextManager[None]:
    return _growing_to(pid, Path(f"{file}-wal").stat().st_size + _PART_OF_A_PAGE)


def _no_bytes(file: Path, pid: int) -> AbstractContextManager[None]:
    return _growing_to(pid, 1)


@contextlib.contextmanager
def _locked(file: Path, pid: int) -> Iterator[None]:
    with contextlib.closing(LIBRARY.connect(file, timeout=_TURN_S, isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        yield
        other.rollback()


@contextlib.contextmanager
def _moved_away(file: Path, pid: int) -> Iterator[None]:
    file.rename(file.with_name("away"))
    file.mkdir()
    yield
    file.rmdir()
    file.with_name("away").rename(file)


@contextlib.contextmanager
def _removed(file: Path, pid: int) -> Iterator[None]:
    file.unlink()
    yield


@contextlib.contextmanager
def _removed_with_its_log(file: Path, pid: int) -> Iterator[None]:
    for ending in ("", "-wal", "-shm"):
        Path(f"{file}{ending}").unlink(missing_ok=True)
    yield


FAULTS: Mapping[str, Callable[[Path, int], AbstractContextManager[None]]] = {
    "no room": _no_room,
    "no bytes": _no_bytes,
    "locked": _locked,
    "removed": _removed,
    "removed with its log": _removed_with_its_log,
    "moved away and back": _moved_away,
}


def lasts_s(fault: str, rng: Random, lock_s: float) -> float:
    """Draw how long a fault lasts; a lock for up to `lock_s`, nothing else for longer."""
    return rng.uniform(0.0, lock_s if fault == "locked" else min(lock_s, _SHORT_S))
