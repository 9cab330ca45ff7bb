"""What the columns of a table are, by their names and by what stands in them: guesses with reasons."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.exchange.import_wizard.headings import (
    LABELS,
    MEANS_NOTHING,
    NOTHING,
    QUANTITIES,
    ColumnMeaning,
    Heading,
    heading,
    motoman,
    series,
)
from truepose.exchange.import_wizard.sheet import Sheet, is_blank, is_number
from truepose.messages.message import Message, message

Certainty: TypeAlias = Literal["certain", "likely", "guess"]
_MOST_RADIANS: Final = 6.6  # a little more than a turn: angles in degrees that stay within it hardly move
_MOST_DEGREES: Final = 720.0
_METRES_MM: Final = 20.0  # points of an arm that spread less are not in millimetres
_FEWEST_JOINTS: Final = 4
_MOST_JOINTS: Final = 9
_ARM: Final = 6


@dataclass(frozen=True, slots=True)
class Guess:
    """What a column is believed to be, how surely, and why."""

    meaning: ColumnMeaning
    certainty: Certainty
    reason: Message


Guesses: TypeAlias = dict[int, Guess]  # by column, from 0


def guess_columns(sheet: Sheet) -> tuple[Guess, ...]:
    """Return a guess for each column of a table."""
    values = [_values(sheet, number) for number in range(len(sheet.header))]
    names = [heading(name) for name in sheet.header]
    found = _by_name(sheet, names, values)
    # Only where no heading says joints: names go before what numbers look like.
    if not _has(found, "joint"):
        found |= _series_like_joints(sheet, values, found)
    if not any(sheet.header):
        found |= _without_names(values)
    found = _one_series(found, names, "joint", prefer_nominal=True)
    found = _one_series(found, names, "torque", prefer_nominal=False)
    found = _points_of_a_row(found, names)
    found = _once_each(found)
    return tuple(
        _with_unit(found[at], found, values) if at in found else _nothing(sheet, at)
        for at in range(len(sheet.header))
    )


def _nothing(sheet: Sheet, column: int) -> Guess:
    key = "bring.why.unknown" if sheet.header[column] else "bring.why.nameless"
    return Guess(MEANS_NOTHING, "likely", message(key))


def _values(sheet: Sheet, number: int) -> FloatArray:
    """Return the numbers of a column; NaN for what is none."""
    return np.array([float(cell) if is_number(cell) else np.nan for cell in sheet.column(number)])


def _has(found: Mapping[int, Guess], quantity: str) -> bool:
    return any(guess.meaning.quantity == quantity for guess in found.values())


def _by_name(sheet: Sheet, names: Sequence[Heading], values: Sequence[FloatArray]) -> Guesses:
    letters = motoman(list(sheet.header))
    found: Guesses = {
        at: Guess(ColumnMeaning("joint", joint), "certain", message("bring.why.motoman"))
        for at, joint in letters.items()
    }
    for at, name in enumerate(names):
        if at in found or name.meaning.quantity == NOTHING:
            continue
        if _can_be(name.meaning, sheet, at, values[at]):
            found[at] = Guess(
                name.meaning, _certainty(name), message("bring.why.name", name=sheet.header[at])
            )
    return _from_one(found)


def _certainty(name: Heading) -> Certainty:
    units = QUANTITIES[name.meaning.quantity].units
    return "certain" if name.meaning.unit in units or not units else "likely"


def _can_be(meaning: ColumnMeaning, sheet: Sheet, column: int, values: FloatArray) -> bool:
    """Whether what stands in a column can be what its name says: a number, or a label of a place."""
    if meaning.quantity in LABELS or meaning.quantity == "time":
        return True
    given = sum(not is_blank(cell) for cell in sheet.column(column))
    return bool(np.isfinite(values).sum() > 0.5 * given)


def _from_one(found: Guesses) -> Guesses:
    """Return joints numbered from 1 where a table numbers them from 0."""
    for quantity in ("joint", "torque", "direction"):
        own = {at: guess for at, guess in found.items() if guess.meaning.quantity == quantity}
        if own and min(guess.meaning.number for guess in own.values()) == 0:
            for at, guess in own.items():
                meaning = replace(guess.meaning, number=guess.meaning.number + 1)
                found[at] = replace(
                    guess, meaning=meaning, certainty="likely", reason=message("bring.why.from_zero")
                )
    return found


def _series_like_joints(sheet: Sheet, values: Sequence[FloatArray], found: Guesses) -> Guesses:
    """Return columns of no known word that are named alike and numbered, and hold what angles can be."""
    groups: dict[str, dict[int, int]] = defaultdict(dict)
    for at, name in enumerate(sheet.header):
        named = series(name)
        if named is not None and at not in found and _like_angles(values[at]):
            groups[named[0]][named[1]] = at
    for numbers in groups.values():
        least = min(numbers)
        run = [numbers.get(least + k) for k in range(len(numbers))]
        if _FEWEST_JOINTS <= len(run) <= _MOST_JOINTS and None not in run and least in {0, 1}:
            reason = message("bring.why.series", count=len(run))
            return {
                at: Guess(ColumnMeaning("joint", k), "likely", reason)
                for k, at in enumerate((at for at in run if at is not None), start=1)
            }
    return {}


def _like_angles(values: FloatArray) -> bool:
    given = values[np.isfinite(values)]
    return bool(len(given)) and bool(np.abs(given).max() <= _MOST_DEGREES)


def _without_names(values: Sequence[FloatArray]) -> Guesses:
    """Return the usual order of a table without names: perhaps a number, six angles, three coordinates."""
    first = 1 if len(values) > _ARM + 3 and _counts(values[0]) else 0
    free = range(first, len(values))
    if len(free) < _ARM + 3 or not all(_like_angles(values[at]) for at in free[:_ARM]):
        return {}
    reason = message("bring.why.order")
    joints: Guesses = {
        at: Guess(ColumnMeaning("joint", k), "guess", reason) for k, at in enumerate(free[:_ARM], 1)
    }
    places = {
        at: Guess(ColumnMeaning("position", k), "guess", reason)
        for k, at in enumerate(free[_ARM : _ARM + 3], 1)
    }
    numbers = {0: Guess(ColumnMeaning("config"), "guess", message("bring.why.counts"))} if first else {}
    return joints | places | numbers


def _counts(values: FloatArray) -> bool:
    return bool(
        np.all(np.isfinite(values)) and np.all(values == np.round(values)) and np.all(np.diff(values) >= 0)
    )


def _one_series(found: Guesses, names: Sequence[Heading], quantity: str, *, prefer_nominal: bool) -> Guesses:
    """Keep one of several series of joints: commanded angles go before those that are read back."""
    series_of: dict[str, list[int]] = defaultdict(list)
    for at, guess in found.items():
        if guess.meaning.quantity == quantity:
            series_of[names[at].stem].append(at)
    if len(series_of) < 2:
        return found
    numbers = [found[at].meaning.number for columns in series_of.values() for at in columns]
    if len(set(numbers)) == len(numbers):
        return found
    # The commanded angles are what the controller's nominal model makes a pose of, and that pose is what the
    # identified model has to correct.
    kept = max(
        series_of,
        key=lambda stem: (len(series_of[stem]), names[series_of[stem][0]].nominal == prefer_nominal),
    )
    for stem, columns in series_of.items():
        for at in columns:
            if stem == kept:
                found[at] = replace(found[at], certainty="likely", reason=message("bring.why.one_of_series"))
            else:
                found[at] = Guess(MEANS_NOTHING, "likely", message("bring.why.other_series"))
    return found


def _points_of_a_row(found: Guesses, names: Sequence[Heading]) -> Guesses:
    """Tell several points of a row apart; of nominal and measured coordinates the measured ones count."""
    groups: dict[str, list[int]] = defaultdict(list)
    for at, guess in sorted(found.items()):
        if guess.meaning.quantity == "position":
            groups[_group(names[at], groups, found, guess.meaning.number)].append(at)
    whole = {stem: columns for stem, columns in groups.items() if len(columns) == 3}
    measured = {stem: columns for stem, columns in whole.items() if not names[columns[0]].nominal}
    said_so = {stem: columns for stem, columns in measured.items() if names[columns[0]].measured} or measured
    for point, columns in enumerate(said_so.values(), start=1 if len(said_so) > 1 else 0):
        for at in columns:
            found[at] = replace(found[at], meaning=replace(found[at].meaning, point=point))
    for columns in groups.values():
        for at in columns:
            if columns not in said_so.values():
                found[at] = Guess(MEANS_NOTHING, "likely", message("bring.why.not_measured"))
    return found


def _group(name: Heading, groups: Mapping[str, list[int]], found: Guesses, axis: int) -> str:
    """Return a name for the point that a coordinate belongs to; `x1 y1 z1 x2` has two of one stem."""
    stem, again = name.stem, 1
    while any(found[at].meaning.number == axis for at in groups.get(f"{stem} {again}", ())):
        again += 1
    return f"{stem} {again}"


def _once_each(found: Guesses) -> Guesses:
    """Keep the first of columns that would be the same."""
    seen: set[ColumnMeaning] = set()
    for at in sorted(found, key=lambda at: (found[at].certainty != "certain", at)):
        key = replace(found[at].meaning, unit="")
        if key.quantity != NOTHING and key in seen:
            found[at] = Guess(MEANS_NOTHING, "likely", message("bring.why.second"))
        seen.add(key)
    return found


def _with_unit(guess: Guess, found: Guesses, values: Sequence[FloatArray]) -> Guess:
    """Return the guess with a unit: that of its name, else what the size of all columns of its kind says."""
    meaning = guess.meaning
    units = QUANTITIES[meaning.quantity].units
    if not units or meaning.unit in units:
        return guess
    # All columns of a kind together: by itself a joint that hardly moves would look like radians.
    kind = [at for at, other in found.items() if other.meaning.quantity == meaning.quantity]
    unit, key = _unit_by_size(
        meaning.quantity, np.concatenate([values[at] for at in kind]), next(iter(units))
    )
    certainty: Certainty = "guess" if guess.certainty == "guess" else "likely"
    reason = message("bring.why.and", first=guess.reason, second=message(key, unit=unit))
    return Guess(replace(meaning, unit=unit), certainty, reason)


def _unit_by_size(quantity: str, values: FloatArray, usual: str) -> tuple[str, str]:
    given = np.abs(values[np.isfinite(values)])
    largest = float(given.max(initial=0.0))
    if quantity == "joint" and 0.0 < largest <= _MOST_RADIANS:
        return "rad", "bring.why.small_angles"
    if quantity in {"position", "length"} and 0.0 < largest <= _METRES_MM:
        return "m", "bring.why.small_lengths"
    if quantity == "temperature" and largest > 200.0:
        return "K", "bring.why.kelvin"
    return usual, "bring.why.usual_unit"
