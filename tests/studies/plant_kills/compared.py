"""What cells and plant have against each other and against what was acknowledged.

All of it is read from the databases themselves, not through a service.
"""

import itertools
import json
import sqlite3
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeAlias

import psycopg

from tests.studies.plant_kills.delivering import reading
from truepose.storage.engine.address import database_file
from truepose.storage.integrity.verification import verify_left_at

Link: TypeAlias = tuple[int, int, str, int, bytes]  # link, stream, record, number of the record, hash
_CHAIN = "SELECT id, stream, record, record_id, hash FROM links ORDER BY id"
_OF_CELL = (
    "FROM plant_journal JOIN plant_branches ON plant_branches.id = branch_id "
    "JOIN plant_cells ON plant_cells.id = cell_id WHERE plant_cells.name = "
)
_DELIVERIES = "SELECT series_id, first, count, CAST(document AS TEXT) FROM deliveries ORDER BY id"


@dataclass(slots=True)
class Compared:
    """What was found wrong, counted; all zero where nothing was."""

    lost: int = 0  # links of a cell that the plant does not have
    doubled: int = 0
    reordered: int = 0
    foreign: int = 0  # links of the plant that its cell does not have
    unseen: int = 0  # acknowledged to a program or a person, and not kept, in cell or plant
    other_values: int = 0  # readings that say something else than what was sent
    kept_twice: int = 0  # hand-downs
    branches: int = 0  # beyond one a cell
    findings: int = 0  # of 'truepose verify' on all databases
    unwell: int = 0  # services that say that something is amiss

    def add(self, other: "Compared") -> None:
        """Count what another comparison found as well."""
        for field in fields(self):
            setattr(self, field.name, getattr(self, field.name) + getattr(other, field.name))

    @property
    def clean(self) -> bool:
        """Whether nothing was wrong."""
        return not any(getattr(self, field.name) for field in fields(self))


def read_acknowledged(file: Path) -> list[dict[str, Any]]:
    """Return what was acknowledged, as it was noted."""
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


def compared(
    cells: Mapping[str, str], plant: str, acknowledged: Sequence[Mapping[str, Any]]
) -> tuple[Compared, dict[str, int]]:
    """Compare cells with their plant, all by address of their database; returns also how much there is."""
    found, links = Compared(), 0
    for name, cell in cells.items():
        chain = chain_of(cell)
        links += len(chain)
        of_this = [told for told in acknowledged if told["cell"] == name]
        found.add(_of_chain(chain, journal_of(plant, name)))
        for kept in (_rows(cell, _DELIVERIES), _collected_deliveries(plant, name)):
            found.add(_of_readings(kept, of_this))
        found.add(_of_keys(of_this, plant, name))
        found.add(_of_hand_downs(_names(cell, "SELECT name FROM handed_down"), of_this))
    found.add(_of_hand_downs(_names(plant, "SELECT name FROM plant_hand_downs"), acknowledged))
    found.branches = len(_rows(plant, "SELECT id FROM plant_branches")) - len(cells)
    found.findings = sum(len(verify_left_at(url).findings) for url in (*cells.values(), plant))
    readings = sum(told.get("count", 0) for told in acknowledged)
    return found, {"links": links, "acknowledged": len(acknowledged), "readings": readings}


def kept_readings(cell: str, acknowledged: Sequence[Mapping[str, Any]]) -> Compared:
    """Compare the readings that a cell has with those that were acknowledged."""
    return _of_readings(_rows(cell, _DELIVERIES), acknowledged)


def chain_of(cell: str) -> list[Link]:
    """Return the links of a cell's database."""
    return _rows(cell, _CHAIN)


def journal_of(plant: str, cell: str) -> list[Link]:
    """Return the links that a plant has of a cell, in the order in which it kept them."""
    columns = "plant_journal.link, stream, record, record_id, hash"
    return _rows(plant, f"SELECT {columns} {_OF_CELL}'{cell}' ORDER BY plant_journal.id")


def waiting_hand_downs(plant: str) -> int:
    """Return how many hand-downs the plant has not yet delivered."""
    delivered = "SELECT hand_down_id FROM plant_hand_down_states WHERE state = 'delivered'"
    return len(_rows(plant, f"SELECT id FROM plant_hand_downs WHERE id NOT IN ({delivered})"))


def _of_chain(chain: Sequence[Link], journal: Sequence[Link]) -> Compared:
    collected = set(journal)
    return Compared(
        lost=len(set(chain) - collected),
        doubled=len(journal) - len(collected),
        reordered=sum(after[0] != before[0] + 1 for before, after in itertools.pairwise(journal)),
        foreign=len(collected - set(chain)),
    )


def _of_readings(
    kept: Iterable[tuple[int, int, int, str]], acknowledged: Sequence[Mapping[str, Any]]
) -> Compared:
    found, ends = Compared(), defaultdict[int, int](int)
    for series, first, count, document in kept:
        found.doubled += first <= ends[series]
        found.reordered += first > ends[series] + 1
        sent = [reading(series, number) for number in range(first, first + count)]
        found.other_values += json.loads(document) != sent
        ends[series] = first + count - 1
    for told in acknowledged:
        if "series" in told:
            found.unseen += ends[told["series"]] < told["first"] + told["count"] - 1
    return found


def _of_keys(acknowledged: Sequence[Mapping[str, Any]], plant: str, cell: str) -> Compared:
    acts = [(told["session"], told["act"]) for told in acknowledged if "act" in told]
    if not acts:
        return Compared()
    kept = Counter(
        (row["session_id"], row["key"])
        for row in _contents(plant, cell, "session_entries")
        if row.get("key") is not None
    )
    return Compared(
        unseen=sum(kept[act] == 0 for act in acts), doubled=sum(count > 1 for count in kept.values())
    )


def _of_hand_downs(kept: Sequence[str], acknowledged: Sequence[Mapping[str, Any]]) -> Compared:
    names = Counter(kept)
    wanted = [told["handed_down"] for told in acknowledged if "handed_down" in told]
    return Compared(
        unseen=sum(names[name] == 0 for name in wanted),
        kept_twice=sum(count > 1 for count in names.values()),
    )


def _collected_deliveries(plant: str, cell: str) -> Iterator[tuple[int, int, int, str]]:
    for row in _contents(plant, cell, "deliveries"):
        yield row["series_id"], row["first"], row["count"], row["document"]


def _contents(plant: str, cell: str, record: str) -> Iterator[dict[str, Any]]:
    """Yield the records of a kind that a plant has of a cell, in the order of the chain."""
    asked = f"SELECT content {_OF_CELL}'{cell}' AND record = '{record}' ORDER BY plant_journal.id"
    yield from (json.loads(content) for (content,) in _rows(plant, asked))


def _names(url: str, query: str) -> list[str]:
    return [name for (name,) in _rows(url, query)]


def _rows(url: str, query: str) -> list[tuple]:
    if url.startswith("sqlite"):
        with closing(sqlite3.connect(database_file(url))) as connection:
            return connection.execute(query).fetchall()
    with psycopg.connect(url) as connection:
        return connection.execute(query).fetchall()
