"""Which file identifies and which judges, and the tables of a campaign made of them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import FloatArray, IntArray
from truepose.exchange.errors import BadValueError
from truepose.exchange.import_wizard.column_detection import Guess, guess_columns
from truepose.exchange.import_wizard.columns import (
    Cells,
    ImportedTable,
    ImportedValueError,
    in_format,
    join_readings,
)
from truepose.exchange.import_wizard.dialogue import Choices
from truepose.exchange.import_wizard.files import Piece
from truepose.exchange.import_wizard.headings import MEANS_NOTHING, ColumnMeaning
from truepose.exchange.import_wizard.sheet import Sheet
from truepose.exchange.quantities import limits_of
from truepose.exchange.tables.fields import NO_REPEAT, SAME_JOINTS_DEG
from truepose.messages.message import Message, message

_SAME_DEG: Final = 1e-3  # steps in which controllers show an angle


def numbers_its_stops(config: npt.NDArray[Any] | None, joints_deg: FloatArray, ends: IntArray) -> bool:
    """Whether `config` numbers each stop once: whole numbers, one place each, no end of it read twice."""
    if config is None or config.dtype == object or not np.all(np.isfinite(config)):
        return False
    if np.any(config != np.round(config)) or np.any(config < 0):
        return False
    _, first, which = np.unique(config, return_index=True, return_inverse=True)
    away = np.abs(joints_deg - joints_deg[first[which.reshape(-1)]]).max(axis=1)
    pairs = np.unique(np.column_stack([config, ends]), axis=0)
    return bool(np.all(away <= SAME_JOINTS_DEG)) and len(pairs) == len(config)


def numbered_stops(joints_deg: FloatArray, ends: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return `config` and `repeat_of` of readings in their order.

    A stop ends where the joints change, or where an end is read that this stop has already; one with the
    joints of an earlier one is a revisit of it.

    Parameters
    ----------
    joints_deg : ndarray, shape (n, J)
    ends : ndarray, shape (n,)
        What was read: the nest, or a number for each pair of ends of a length.
    """
    config, repeat_of = np.zeros(len(ends)), np.full(len(ends), float(NO_REPEAT))
    first_of: dict[tuple[float, ...], int] = {}
    stop, seen = 0, set[int]()
    for row, (joints, end) in enumerate(zip(joints_deg, ends.tolist(), strict=True)):
        moved = row == 0 or bool(np.abs(joints - joints_deg[row - 1]).max() > _SAME_DEG)
        if moved or end in seen:
            stop, seen = stop + 1, set()
        seen.add(end)
        place = tuple(np.round(joints / _SAME_DEG).tolist())
        earlier = first_of.setdefault(place, stop)
        config[row] = stop
        repeat_of[row] = NO_REPEAT if earlier == stop else earlier
    return config, repeat_of


def scatter_of_revisits_mm(
    position_mm: FloatArray, nest: IntArray, config: FloatArray, repeat_of: FloatArray
) -> float | None:
    """Return the standard deviation per axis of places measured again; None where few were."""
    place = np.where(repeat_of == NO_REPEAT, config, repeat_of)
    squares, freedom = 0.0, 0
    for rows in _groups(np.column_stack([place, nest])):
        if len(rows) > 1:
            squares += float(np.sum(np.square(position_mm[rows] - position_mm[rows].mean(axis=0))))
            freedom += 3 * (len(rows) - 1)
    return float(np.sqrt(squares / freedom)) if freedom >= _FEWEST_REVISITS else None


_FEWEST_REVISITS: Final = 15  # of three axes each


def _groups(keys: FloatArray) -> Sequence[IntArray]:
    _, which = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(which.reshape(-1)[order])) + 1)


_JUDGES: Final = re.compile(
    r"valid|verif|check|test|pr(?:ue|\u00fc|u)f|kontroll|contr[o\u00f4]l|held.?out|collaudo|over[e\u011b]r",
    re.IGNORECASE,
)
_PAIRS: Final = 1000.0  # more nests than anybody has
_AXES: Final = ("x_mm", "y_mm", "z_mm")


@dataclass(frozen=True, slots=True)
class DetectedTable:
    """A sheet, what its columns are, and what it is for."""

    sheet: Sheet
    guesses: tuple[Guess, ...]  # as a person corrected them
    said_columns: frozenset[int]  # that a person chose
    role: str
    reason: Message

    @property
    def meanings(self) -> tuple[ColumnMeaning, ...]:
        """What each column is."""
        return tuple(guess.meaning for guess in self.guesses)

    def has(self, quantity: str) -> bool:
        """Whether one of its columns is that."""
        return any(one.quantity == quantity for one in self.meanings)


def detected_tables(pieces: Sequence[Piece], choices: Choices) -> tuple[DetectedTable, ...]:
    """Return the sheets with columns and roles, those that a person chose before those that are guessed."""
    sheets = [(piece.sheet, *_columns(piece.sheet, choices)) for piece in pieces if piece.sheet is not None]
    roles = _roles(sheets)
    found = []
    for (sheet, guesses, chosen), (role, reason) in zip(sheets, roles, strict=True):
        own = choices.of(sheet.name).role
        found.append(
            DetectedTable(sheet, guesses, chosen, own or role, message("bring.role.said") if own else reason)
        )
    return tuple(found)


def _columns(sheet: Sheet, choices: Choices) -> tuple[tuple[Guess, ...], frozenset[int]]:
    chosen = choices.of(sheet.name).columns
    said = {replace(meaning, unit="") for meaning in chosen.values()} - {MEANS_NOTHING}
    guesses = []
    for at, guess in enumerate(guess_columns(sheet)):
        if at in chosen:
            guess = Guess(chosen[at], "certain", message("bring.why.said"))
        elif replace(guess.meaning, unit="") in said:
            guess = Guess(MEANS_NOTHING, "likely", message("bring.why.second"))
        guesses.append(guess)
    return tuple(guesses), frozenset(chosen)


def _roles(
    sheets: Sequence[tuple[Sheet, tuple[Guess, ...], frozenset[int]]],
) -> list[tuple[str, Message]]:
    kinds = [_kind([guess.meaning for guess in guesses]) for _, guesses, _ in sheets]
    judging = [bool(_JUDGES.search(sheet.name)) for sheet, _, _ in sheets]
    readable = [at for at, kind in enumerate(kinds) if kind]
    # Of two tables of one kind with no word on either the larger one identifies: a model needs more readings
    # than its judge.
    if len(readable) == 2 and not any(judging) and kinds[readable[0]] == kinds[readable[1]]:
        smaller = min(readable, key=lambda at: len(sheets[at][0].rows))
        return [_role(kind, at == smaller, "bring.role.size") for at, kind in enumerate(kinds)]
    # Where every name has such a word (a folder of a `test`) it tells nothing.
    if readable and all(judging[at] for at in readable):
        judging = [False] * len(sheets)
    return [_role(kind, judges, "bring.role.name") for kind, judges in zip(kinds, judging, strict=True)]


def _kind(meanings: Sequence[ColumnMeaning]) -> str:
    """Return what a sheet measures: points, lengths, or "" for neither (half a table, or none)."""
    names = {one.quantity for one in meanings}
    if "position" in names:
        return "points"
    return "lengths" if "length" in names else ""


def _role(kind: str, judges: bool, judging: str) -> tuple[str, Message]:
    if not kind:
        return "nothing", message("bring.role.no_readings")
    reason = message(judging) if judges else message("bring.role.calibration")
    if kind == "points":
        return "validation" if judges else "calibration", reason
    return "validation_legs" if judges else "legs", reason


def by_role(sheets: Sequence[DetectedTable]) -> dict[str, ImportedTable]:
    """Return the readings of each role; raises InputFileError at a torn row or a bad cell."""
    # Controllers log angles and instruments log points: two files, of which neither is a table of readings.
    halves = [one for one in sheets if one.has("joint") and not one.has("position") and not one.has("length")]
    found: dict[str, list[ImportedTable]] = {}
    for one in sheets:
        if one.role != "nothing":
            own = in_format(one.sheet, one.meanings)
            if not one.has("joint") and halves:
                own = _with_joints(own, in_format(halves[0].sheet, halves[0].meanings))
            found.setdefault(one.role, []).append(own)
    return {role: _numbered(join_readings(parts), several=len(parts) > 1) for role, parts in found.items()}


def own_table(one: DetectedTable) -> ImportedTable:
    """Return one sheet by itself, its stops numbered; raises InputFileError at a torn row or a bad cell."""
    return _numbered(in_format(one.sheet, one.meanings), several=False)


def _with_joints(points: ImportedTable, joints: ImportedTable) -> ImportedTable:
    """Return points with the angles of another table: by their number, else row by row."""
    rows = _rows_of(points, joints)
    missing = {name: cells[rows] for name, cells in joints.columns.items() if name not in points.columns}
    return replace(points, columns={**missing, **points.columns})


def _rows_of(points: ImportedTable, joints: ImportedTable) -> IntArray:
    """Return the row of the joints of each point; raises BadValueError where one has none."""
    wanted, there = points.columns.get("config"), joints.columns.get("config")
    if wanted is None or there is None:
        if len(points) != len(joints):
            raise BadValueError(
                f"it has {len(points)} rows and {joints.places[0].file} has {len(joints)}: "
                "a column in both must show which rows belong together",
                file=points.places[0].file,
            )
        return np.arange(len(points))
    row_of = {value: row for row, value in reversed(list(enumerate(there.tolist())))}
    for row, value in enumerate(wanted.tolist()):
        if value not in row_of:
            sentence = f"no row of {joints.places[0].file} has the joints for this row"
            raise ImportedValueError(sentence, points.places[row], "config")
    return np.array([row_of[value] for value in wanted.tolist()])


def _numbered(table: ImportedTable, *, several: bool) -> ImportedTable:
    """Return a table whose stops are numbered; an end or a placement that nobody named is the first."""
    _require_numbers(table)
    columns = dict(table.columns)
    ones = np.ones(len(table))
    if "length_mm" in columns and "x_mm" not in columns:
        ends: tuple[str, ...] = ("base_point", "tool_point")
        columns.setdefault("placement", ones)
        columns.setdefault("tool_point", columns.pop("nest", ones))
    else:
        ends = ("nest",)
    columns |= {end: ones for end in ends if end not in columns}
    joints = joints_of(columns)
    if joints.shape[1]:
        pair = whole_or_0(columns[ends[0]] * _PAIRS + columns[ends[-1]])
        # Two tables each count from 1: their numbers would join stops that have nothing in common.
        if several or not numbers_its_stops(columns.get("config"), joints, pair):
            columns["config"], columns["repeat_of"] = numbered_stops(joints, pair)
    return replace(table, columns=columns)


def joints_of(columns: Mapping[str, Cells]) -> FloatArray:
    """Return the angles of a table [deg], shape (n, J)."""
    names = [f"q{joint}_deg" for joint in range(1, n_joints(columns) + 1)]
    return np.column_stack([columns[name].astype(float) for name in names]) if names else np.zeros((0, 0))


def n_joints(columns: Mapping[str, Cells]) -> int:
    """Return how many joints there are, without a gap."""
    count = 0
    while f"q{count + 1}_deg" in columns:
        count += 1
    return count


def positions_of(columns: Mapping[str, Cells]) -> FloatArray:
    """Return the positions of a table [mm], shape (n, 3)."""
    return np.column_stack([columns[name].astype(float) for name in _AXES])


def has_positions(columns: Mapping[str, Cells]) -> bool:
    """Whether all three coordinates are there."""
    return all(name in columns for name in _AXES)


def whole_or_0(cells: Cells) -> IntArray:
    """Return whole numbers; 0 for an empty cell, which whoever reads the table as a campaign refuses."""
    numbers: IntArray = np.nan_to_num(cells.astype(float), nan=0.0).astype(np.int64)
    return numbers


def _require_numbers(table: ImportedTable) -> None:
    """Refuse the first cell that is no number or that nobody can have read; raises ImportedValueError."""
    faults = [fault for name, cells in table.columns.items() for fault in _bad_cells(name, cells)]
    for row, name, sentence in sorted(faults)[:1]:
        raise ImportedValueError(sentence, table.places[row], name)


def _bad_cells(name: str, cells: Cells) -> Iterator[tuple[int, str, str]]:
    """Yield row, column and sentence of the first bad cell of a column."""
    limits = limits_of(name)
    for row, cell in enumerate(cells.tolist()):
        if isinstance(cell, str):
            yield row, name, f"{cell[:30]!r} is not a number; correct it, or leave the line out"
            return
        if cell == cell and not limits.accepts(cell):
            yield row, name, f"{limits.fault(cell, f'{cell:g}')}, or leave the line out"
            return
