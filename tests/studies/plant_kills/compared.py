"""The journal of a plant against the chain of its cell, both read from their files, not through a service."""

import itertools
import json
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

Link: TypeAlias = tuple[int, int, str, int, bytes]  # link, stream, record, number of the record, hash
_CHAIN = "SELECT id, stream, record, record_id, hash FROM links ORDER BY id"
_JOURNAL = "SELECT link, stream, record, record_id, hash FROM plant_journal ORDER BY id"
_KEYS = "SELECT content FROM plant_journal WHERE record = 'session_entries'"


@dataclass(frozen=True, slots=True)
class Compared:
    """What was found wrong."""

    lost: int
    doubled: int
    reordered: int
    foreign: int  # links of the plant that the cell does not have
    unseen_acts: int  # acknowledged to the person, and not in the plant


def compared(chain: Sequence[Link], journal: Sequence[Link], acts: Iterable[str], kept: set[str]) -> Compared:
    """Compare what a cell has with what its plant has, and the keys of acknowledged acts with those kept."""
    collected = set(journal)
    return Compared(
        lost=len(set(chain) - collected),
        doubled=len(journal) - len(collected),
        reordered=sum(after[0] != before[0] + 1 for before, after in itertools.pairwise(journal)),
        foreign=len(collected - set(chain)),
        unseen_acts=len(set(acts) - kept),
    )


def chain_of(cell: Path) -> list[Link]:
    """Return the links of a cell's database."""
    return _rows(cell, _CHAIN)


def journal_of(plant: Path) -> list[Link]:
    """Return the links that a plant has, in the order in which it kept them."""
    return _rows(plant, _JOURNAL)


def keys_of(plant: Path) -> set[str]:
    """Return the keys of the acts that a plant has."""
    return {json.loads(content).get("key") for (content,) in _rows(plant, _KEYS)} - {None}


def _rows(file: Path, query: str) -> list[tuple]:
    with closing(sqlite3.connect(file)) as connection:
        return connection.execute(query).fetchall()
