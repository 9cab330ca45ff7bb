"""Lists of points as metrology programs export them: a name of one to three words, then x, y, z.

SpatialAnalyzer writes `collection group target x y z`, or fewer words of the name, separated by commas or
blanks, with `//` before comments (its user's manual, "Exporting ASCII formatted points"); PowerInspect
`"name" x y z i j k`; PolyWorks, Verisurf and others write tables with a header. What stands behind the
coordinates is passed over, unless a header names it.
"""

import csv
import io
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, NamedTuple

from truepose.exchange.errors import BadValueError, MissingEntryError, UnreadableFileError, WrongUnitError
from truepose.exchange.tables.rows import LONGEST_LINE
from truepose.exchange.tables.table_reader import shown

MOST_LINES: Final = 200_000
_COMMENTS: Final = ("//", "#", "!", "%", "*")
_SEPARATORS: Final = ("\t", ";", ",")
_WORD: Final = re.compile(r'"([^"]*)"|\'([^\']*)\'|(\S+)')
_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d+,\d+")


class Line(NamedTuple):
    """What stands in a line that is no comment."""

    number: int  # 1-based
    words: tuple[str, ...]


def lines_of(file: str, data: bytes) -> tuple[list[Line], list[str]]:
    """Return the lines with words, and the comments; raises UnreadableFileError."""
    texts = list(_stripped_lines(file, data))
    said = [line for _, line in texts if line.startswith(_COMMENTS)]
    kept = [(number, line) for number, line in texts if line and not line.startswith(_COMMENTS)]
    if not kept:
        raise UnreadableFileError("it has no points", file=file)
    # Once for the file: line by line a comma in a name would pass for a separator.
    separator = _separator(kept[0][1])
    return [Line(number, tuple(_words(line, separator))) for number, line in kept], said


def _stripped_lines(file: str, data: bytes) -> Iterator[tuple[int, str]]:
    """Yield the lines and their numbers, counted as they come."""
    for number, line in enumerate(io.StringIO(_text(file, data), newline=None), start=1):
        if number > MOST_LINES:
            raise UnreadableFileError(f"it has more than {MOST_LINES:,} lines, which is the limit", file=file)
        if len(line) > LONGEST_LINE:
            raise UnreadableFileError(
                f"the line has more than {LONGEST_LINE:,} characters", file=file, line=number
            )
        yield number, line.strip()


def _text(file: str, data: bytes) -> str:
    if b"\0" in data:
        raise UnreadableFileError("this is not text; export the points as a text file", file=file)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")  # as programs under Windows write names


def _separator(line: str) -> str | None:
    """Return what separates the words of a file, by its first line; None: blanks."""
    outside_quotes = re.sub(r'"[^"]*"', "", line)
    return next((one for one in _SEPARATORS if one in outside_quotes), None)


def _words(line: str, separator: str | None) -> Iterator[str]:
    if separator is None:
        for match in _WORD.finditer(line):
            yield next(part for part in match.groups() if part is not None)
        return
    (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
    for cell in cells:
        word = cell.strip()
        yield word.replace(",", ".") if separator != "," and _DECIMAL_COMMA.fullmatch(word) else word


Vector = tuple[float, float, float]
UNITS_MM: Final[Mapping[str, float]] = MappingProxyType({"mm": 1.0, "m": 1000.0, "cm": 10.0, "in": 25.4})
_AXES: Final = "xyz"
_SPELLINGS: Final = (("mm", "millimet"), ("cm", "centimet"), ("in", "inch"), ("m", "met"))
_UNIT: Final = r"(?:[ _]*[(\[]?(?P<unit>mm|millimet\w*|cm|centimet\w*|in|inch\w*|m|met\w*)[)\]]?)?"
_MEASURED: Final = re.compile(rf"(?:(?:measured|meas|actual|act)[ _.]*)?(?P<axis>[xyz]){_UNIT}")
_SPREAD: Final = re.compile(rf"(?:u|sigma|sd|unc\w*)[ _.]*(?P<axis>[xyz]){_UNIT}")
_NAMES: Final = frozenset({"name", "point", "point name", "target", "target name", "label", "id", "point id"})
_SAID: Final = re.compile(r"units?\b\W*(?:(?:are|in|length)\b)?\W*(?P<unit>[a-z]+)", re.IGNORECASE)
_NUMBER: Final = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_WHOLE: Final = re.compile(r"\d+")


@dataclass(frozen=True, slots=True)
class NamedPoint:
    """A point of a list."""

    name: str  # the last word of it: collection and group go before
    position_mm: Vector
    uncertainty_mm: Vector | None  # standard, per axis
    line: int


@dataclass(frozen=True, slots=True)
class _Columns:
    """Where what stands in a line."""

    name: int
    position: tuple[int, ...]
    uncertainty: tuple[int, ...]
    unit: str | None


def read_point_list(file: str, data: bytes, unit: str | None = None) -> tuple[NamedPoint, ...]:
    """Return the points of a list, in their order.

    Parameters
    ----------
    file : str
        Its name, for sentences.
    data : bytes
    unit : str, optional
        A key of `UNITS_MM`, of all lengths in it; without it the list itself has to say.

    Raises
    ------
    UnreadableFileError, MissingEntryError, BadValueError, WrongUnitError
        With file and line.
    """
    lines, comments = lines_of(file, data)
    columns = _of_header(lines[0])
    rows = lines if columns is None else lines[1:]
    if not rows:
        raise UnreadableFileError("it has no points", file=file)
    columns = columns or _of_rows(file, rows)
    scale = UNITS_MM[_unit(file, unit, columns.unit or _said(comments))]
    points = tuple(_point(file, line, columns, scale) for line in rows)
    _require_one_each(file, points)
    return points


def _of_header(first: Line) -> _Columns | None:
    """Return where a header says things stand; None where the first line is a point."""
    cells = [word.strip().lower() for word in first.words]
    found = {match["axis"]: at for at, match in _matches(cells, _MEASURED)}
    if set(found) != set(_AXES):
        return None
    units = {_key(match["unit"]) for _, match in _matches(cells, _MEASURED) if match["unit"]}
    spread = {match["axis"]: at for at, match in _matches(cells, _SPREAD)}
    named = [at for at, cell in enumerate(cells) if cell in _NAMES]
    return _Columns(
        name=named[0] if named else -1,
        position=tuple(found[axis] for axis in _AXES),
        uncertainty=tuple(spread[axis] for axis in _AXES) if set(spread) == set(_AXES) else (),
        unit=units.pop() if len(units) == 1 else None,
    )


def _matches(cells: Sequence[str], pattern: re.Pattern[str]) -> Iterator[tuple[int, re.Match[str]]]:
    """Yield the cells that are of a kind; `measured x` is found behind `x`, and so goes before it."""
    found = [(at, match) for at, cell in enumerate(cells) if (match := pattern.fullmatch(cell))]
    yield from sorted(found, key=lambda one: len(cells[one[0]]))


def _of_rows(file: str, rows: Sequence[Line]) -> _Columns:
    """Return where coordinates begin: behind the last word of every line's name."""
    words = max(_words_before(line) for line in rows)
    first = words + 1 if _numbered(rows, words) else words
    if first == 0:
        raise MissingEntryError(
            "the points have no names; export them with names that contain the configuration",
            file=file,
        )
    return _Columns(first - 1, (first, first + 1, first + 2), (), None)


def _numbered(rows: Sequence[Line], at: int) -> bool:
    """Whether whole numbers are the names there: nothing else is, or decimals stand behind them."""
    if not all(len(line.words) > at + 3 and _WHOLE.fullmatch(line.words[at]) for line in rows):
        return False
    return at == 0 or any("." in word for line in rows for word in line.words[at + 1 : at + 4])


def _words_before(line: Line) -> int:
    """Return how many words stand before the first three numbers in a row."""
    numbers = [_NUMBER.fullmatch(word) is not None for word in line.words]
    starts = (at for at in range(len(numbers) - 2) if all(numbers[at : at + 3]))
    return next(starts, 0)


def _said(comments: Sequence[str]) -> str | None:
    """Return the unit that a comment states, as `// Units: Millimeters`; None where none does."""
    found = (match for comment in comments if (match := _SAID.search(comment)))
    return next((key for match in found if (key := _key(match["unit"]))), None)


def _key(spelled: str) -> str | None:
    spelled = spelled.lower()
    return next((key for key, stem in _SPELLINGS if spelled == key or spelled.startswith(stem)), None)


def _unit(file: str, given: str | None, found: str | None) -> str:
    if given is None and found is None:
        raise WrongUnitError(
            f"the list does not state its unit; specify one: {', '.join(UNITS_MM)}", file=file
        )
    # One of the two is wrong by a factor of ten at least, and only people know which.
    if given is not None and found is not None and given != found:
        raise WrongUnitError(f"the list states the unit {found}, but {given} was specified", file=file)
    return given or found or ""


def _point(file: str, line: Line, columns: _Columns, scale: float) -> NamedPoint:
    needed = 1 + max(columns.name, *columns.position, *columns.uncertainty)
    if len(line.words) < needed:
        raise UnreadableFileError(
            f"{len(line.words)} fields found where {needed} are needed", file=file, line=line.number
        )
    spread = _numbers(file, line, columns.uncertainty) if columns.uncertainty else None
    return NamedPoint(
        name=line.words[columns.name] if columns.name >= 0 else str(line.number),
        position_mm=_scaled(_numbers(file, line, columns.position), scale),
        uncertainty_mm=None if spread is None else _scaled(spread, scale),
        line=line.number,
    )


def _numbers(file: str, line: Line, at: Sequence[int]) -> tuple[float, ...]:
    for word in (line.words[place] for place in at):
        if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
            raise BadValueError(f"{shown(word)} is not a coordinate", file=file, line=line.number)
    return tuple(float(line.words[place]) for place in at)


def _scaled(values: Sequence[float], scale: float) -> Vector:
    x, y, z = (value * scale for value in values)
    return x, y, z


def _require_one_each(file: str, points: Sequence[NamedPoint]) -> None:
    seen: dict[str, int] = {}
    for point in points:
        if point.name in seen:
            raise BadValueError(
                f"point {shown(point.name)} is in line {seen[point.name]} as well; keep the valid entry",
                file=file,
                line=point.line,
            )
        seen[point.name] = point.line
