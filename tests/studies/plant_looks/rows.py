"""What a plant has collected from its cells, as rows of its tables, each with its link in the plant's chain.

Journals hold a link for each session, reading and result. Their hashes are of nobody's records: what a plant
answers rests on the newest of each stream alone, which a stand-in of the cell says as well.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import date, timedelta
from typing import Any, Final

from sqlalchemy import Table

from truepose.storage.integrity.hash_chain import GENESIS, linked_hash, stream_of
from truepose.storage.plant.tables import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_instruments,
    plant_journal,
    plant_results,
    plant_robots,
    plant_sessions,
    plant_told,
)
from truepose.storage.tables import links

CELLS: Final = 40
_INSTRUMENTS: Final = 3
_MONTHS: Final = 24
_DAYS: Final = 30  # of a month
_KINDS: Final = ("campaign", "identification", "model", "diagnosis", "report")
_TOLD: Final = ("campaign", "identification", "model", "diagnosis")  # what they tell is beside them
_READING: Final = '{"id":%d,"session_id":%d,"recorded_at":"%s","kind":"point","document":"' + "0" * 240 + '"}'
_CAUSE: Final = {
    "effect": "backlash",
    "unit": "deg",
    "amplitude": 0.02,
    "amplitude_standard_uncertainty": 0.002,
    "worth_mm": 0.03,
}
_OF_NONE: Final = 0  # stream of what belongs to no session


@dataclass(frozen=True, slots=True)
class Row:
    """A record of a table."""

    table: Table
    values: tuple[Any, ...]


@dataclass(slots=True)
class CellChain:
    """What the plant has of one cell."""

    position: int = 0
    heads: dict[int, bytes] = field(default_factory=dict)


@dataclass(slots=True)
class Laid:
    """Everything that was laid so far."""

    numbers: dict[str, int] = field(default_factory=dict)  # by table
    heads: dict[int, bytes] = field(default_factory=dict)  # of the plant's own chain, by stream
    cells: list[CellChain] = field(default_factory=lambda: [CellChain() for _ in range(CELLS)])


@dataclass(frozen=True, slots=True)
class _Session:
    """One robot measured on one day."""

    number: int
    robot: int
    on: str
    readings: int

    @property
    def cell(self) -> int:
        return self.robot % CELLS

    @property
    def of(self) -> dict[str, Any]:
        robot, instrument = f"R-{self.robot}", f"T-{self.robot % _INSTRUMENTS}"
        return {
            "branch_id": self.cell + 1,
            "robot_serial_number": robot,
            "instrument_serial_number": instrument,
        }


def name_of(cell: int) -> str:
    """Return what the plant calls a cell."""
    return f"cell {cell}"


def rows(laid: Laid, robots: int, readings: int, today: date) -> Iterator[Row]:
    """Yield every record with its link behind it, in the order in which a plant comes to them."""
    for table, values in _records(laid, robots, readings, today):
        yield from _linked(laid, table, values)


def _linked(laid: Laid, table: Table, values: dict[str, Any]) -> Iterator[Row]:
    number = laid.numbers[table.name] = laid.numbers.get(table.name, 0) + 1
    names = tuple(column.name for column in table.c)
    row = tuple({"id": number, **values}.get(name) for name in names)
    stream = stream_of(table.name, names, row)
    linked = linked_hash(laid.heads.get(stream, GENESIS), table.name, names, row)
    laid.heads[stream] = linked
    link = laid.numbers[links.name] = laid.numbers.get(links.name, 0) + 1
    yield Row(table, row)
    yield Row(links, (link, stream, table.name, number, linked))


def _records(laid: Laid, robots: int, readings: int, today: date) -> Iterator[tuple[Table, dict[str, Any]]]:
    first = {"recorded_at": _stamp((today - timedelta(days=_MONTHS * _DAYS)).isoformat())}
    own = {"parent_id": None, "after_link": 0, "person": "", "reason": ""}
    for cell in range(CELLS):
        yield plant_cells, {**first, "name": name_of(cell)}
        yield plant_branches, {**first, "cell_id": cell + 1, **own}
    for instrument in range(_INSTRUMENTS):
        yield plant_instruments, {**first, "serial_number": f"T-{instrument}"}
    for robot in range(robots):
        yield plant_robots, {**first, "serial_number": f"R-{robot}", "robot": "IRB 120"}
    for session in _sessions(robots, readings, today):
        yield from _of_session(laid.cells[session.cell], session)


def _sessions(robots: int, readings: int, today: date) -> Iterator[_Session]:
    """Yield each robot's session of each month, by their days."""
    count = robots * _MONTHS
    by_day = sorted(range(robots), key=lambda robot: -(robot % _DAYS))
    for number in range(count):
        month, place = divmod(number, robots)
        robot = by_day[place]
        ago = (_MONTHS - 1 - month) * _DAYS + robot % _DAYS
        share = readings * (number + 1) // count - readings * number // count
        yield _Session(number + 1, robot, (today - timedelta(days=ago)).isoformat(), share)


def _of_session(chain: CellChain, session: _Session) -> Iterator[tuple[Table, dict[str, Any]]]:
    stamp = {"recorded_at": _stamp(session.on)}
    yield _journal(chain, session, "sessions", session.number)
    yield plant_sessions, {**stamp, **session.of, "session_id": session.number, "robot": "IRB 120"}
    for reading in range(session.readings):
        yield _journal(chain, session, "readings", session.number * 100_000 + reading)
    measured = {"session_id": session.number, "measured_on": session.on, "readings": session.readings}
    yield plant_days, {**stamp, **session.of, **measured}
    for kind in _KINDS:
        yield _journal(chain, session, f"{kind}s", session.number, stream=_OF_NONE)
        told = {
            "kind": kind,
            "link": chain.position,
            "record_id": session.number,
            "name": "",
            "robot": "IRB 120",
        }
        yield plant_results, {**stamp, **session.of, **told, "measured_on": session.on, "clock_offset_s": 0.5}
        if kind in _TOLD:
            tells = {**told, "measured_on": session.on, "verdict": "", **_figures(session, kind)}
            yield plant_told, {**stamp, **session.of, **tells}


def _figures(session: _Session, kind: str) -> dict[str, Any]:
    """Return the error and the causes that a result tells: both differ from month to month."""
    if kind == "identification":
        return {"figure_mm": 0.04 + 0.001 * (session.number % 17), "document": "{}"}
    if kind != "diagnosis":
        return {"document": "{}"}
    causes = [{**_CAUSE, "subject": f"joint {1 + (session.number + n) % 6}"} for n in range(3)]
    return {"document": json.dumps({"asks": 0, "causes": causes})}


def _journal(
    chain: CellChain, session: _Session, record: str, number: int, stream: int | None = None
) -> tuple[Table, dict[str, Any]]:
    chain.position += 1
    stream = session.number if stream is None else stream
    found = hashlib.sha256(f"{session.cell} {chain.position}".encode()).digest()
    chain.heads[stream] = found
    return plant_journal, {
        "recorded_at": _stamp(session.on),
        "branch_id": session.cell + 1,
        "link": chain.position,
        "stream": stream,
        "record": record,
        "record_id": number,
        "hash": found,
        "content": _READING % (number, session.number, session.on),
        "verified": 1,
    }


def _stamp(day: str) -> str:
    return f"{day}T09:12:33.125+00:00"
