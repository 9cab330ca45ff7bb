"""Writes that share a transaction: pending writes, how each ends, and how long commits take."""

import asyncio
import statistics
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, TypeVar

from sqlalchemy import Connection

_KEPT: Final = 100


class CommitTimes:
    """Told by the writer's thread, asked by everybody."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        # A deque with a limit may be added to by one thread and copied by others without a lock.
        self._latest: deque[tuple[float, float]] = deque(maxlen=_KEPT)  # when, and how long it took [s]
        self.told: Callable[[float], None] = lambda seconds: None  # who counts them, on the writer's thread

    def note(self, seconds: float) -> None:
        """Keep how long a commit took."""
        self._latest.append((self._clock(), seconds))
        self.told(seconds)

    def usual_s(self, within_s: float) -> float | None:
        """Return how long the commits of the last time usually took; None where there was none."""
        since = self._clock() - within_s
        recent = [seconds for when, seconds in tuple(self._latest) if when >= since]
        # The median: one commit that met a checkpoint takes many times as long as the others.
        return statistics.median(recent) if recent else None


One = TypeVar("One")
Outcome: TypeAlias = tuple[Any, Exception | None]  # what a write gave, or why it was refused
GroupWrite: TypeAlias = Callable[
    [Connection, Sequence[One]], Sequence[Outcome]
]  # keeps several, an end for each


# Told apart by identity: two writes that are equal are two records.
@dataclass(frozen=True, slots=True, eq=False)
class PendingWrite:
    """A write that waits for its turn."""

    work: GroupWrite[Any]  # run once for all who want the same
    one: Any
    done: "asyncio.Future[Any]"  # of whoever waits


class GroupFailedError(Exception):
    """One of several writes has failed, and with it the transaction that they share."""

    def __init__(self, failed: Sequence[PendingWrite]) -> None:
        super().__init__()
        self.failed = failed


def alone(work: Callable[[Connection], Any]) -> GroupWrite[None]:
    """Return a write of its own as one of which there is no other."""
    return lambda connection, _: [(work(connection), None)]


def run(connection: Connection, together: Sequence[PendingWrite]) -> list[Outcome]:
    """Return how each of these writes ends in one transaction; raises what a single one raises."""
    # In the order in which each kind was first asked for: records of different kinds may change places within
    # a group, those of one kind never do.
    of_works: dict[GroupWrite[Any], list[PendingWrite]] = {}
    for wanted in together:
        of_works.setdefault(wanted.work, []).append(wanted)
    ends: dict[PendingWrite, Outcome] = {}
    for work, wanting in of_works.items():
        try:
            ends.update(zip(wanting, work(connection, [wanted.one for wanted in wanting]), strict=True))
        except Exception as error:
            # Nobody shares its transaction, so its own error is the answer. Otherwise the whole group has to
            # be undone, and only those whose work failed are run alone.
            if len(together) == 1:
                raise
            raise GroupFailedError(wanting) from error
    return [ends[wanted] for wanted in together]
