"""Writes that share a transaction: what is wanted, how each ends, and which of them cannot be together."""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar

from sqlalchemy import Connection

One = TypeVar("One")
End: TypeAlias = tuple[Any, Exception | None]  # what a write gave, or why it was refused
Together: TypeAlias = Callable[[Connection, Sequence[One]], Sequence[End]]  # keeps several, an end for each


@dataclass(frozen=True, slots=True, eq=False)
class Wanted:
    """A write that waits for its turn."""

    work: Together[Any]  # run once for all who want the same
    one: Any
    done: "asyncio.Future[Any]"  # of whoever waits


class NotTogetherError(Exception):
    """One of several writes has failed, and with it the transaction that they share."""

    def __init__(self, failed: Sequence[Wanted]) -> None:
        super().__init__()
        self.failed = failed


def alone(work: Callable[[Connection], Any]) -> Together[None]:
    """Return a write of its own as one of which there is no other."""
    return lambda connection, _: [(work(connection), None)]


def run(connection: Connection, together: Sequence[Wanted]) -> list[End]:
    """Return how each of these writes ends in one transaction; raises what a single one raises."""
    of_works: dict[Together[Any], list[Wanted]] = {}
    for wanted in together:
        of_works.setdefault(wanted.work, []).append(wanted)
    ends: dict[Wanted, End] = {}
    for work, wanting in of_works.items():
        try:
            ends.update(zip(wanting, work(connection, [wanted.one for wanted in wanting]), strict=True))
        except Exception as error:
            if len(together) == 1:
                raise
            raise NotTogetherError(wanting) from error
    return [ends[wanted] for wanted in together]
