"""Readings to set aside as people write them: `17/2=a cable lay in the beam`, or a table with many."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, TypeAlias

from truepose.domain.errors import ConfigurationError
from truepose.domain.set_aside import ReadingNumbers
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import BadValueError, MissingEntryError
from truepose.exchange.tables.rows import numbered_rows, parts, read_header, read_text

NumbersAndReason: TypeAlias = tuple[ReadingNumbers, str]
# As many as a request to the service may name, and as long a reason.
_MOST: Final = 10_000
_LONGEST_REASON: Final = 500
_NUMBER: Final = re.compile("[0-9]{1,9}")
_REQUIRED: Final = ("config", "reason")
# What a reading was read against, then its tool nest: each by the names that tables of campaigns have.
_READ_AGAINST: Final = ("base_point", "target")
_NEST: Final = ("nest", "tool_point")
_EXAMPLE: Final = '"17/2=a cable lay in the beam"'


def reading_and_reason(text: str) -> NumbersAndReason:
    """Return what `--set-aside` names: numbers with slashes between them, and the reason after `=`.

    Raises ConfigurationError.
    """
    named, _, reason = text.partition("=")
    numbers = [number.strip() for number in named.split("/")]
    if not all(map(_NUMBER.fullmatch, numbers)):
        raise ConfigurationError(
            f"--set-aside {text}: name the reading by the numbers of its configuration and nest, and give "
            f"the reason, as in {_EXAMPLE}."
        )
    reason = _on_one_line(reason)
    if not 0 < len(reason) <= _LONGEST_REASON:
        raise ConfigurationError(
            f"--set-aside {named.strip()}: a reason of 1 to {_LONGEST_REASON} characters is required, as in "
            f"{_EXAMPLE}."
        )
    return tuple(map(int, numbers)), reason


def read_set_aside_table(file: Path) -> list[NumbersAndReason]:
    """Read `config, nest, reason`, with `base_point` for lengths or `target` for contacts.

    `tool_point` is the nest as well; other columns say nothing here. Where a configuration has one reading
    alone, the cells beside its number may be empty.

    Raises
    ------
    InputFileError
        A column is missing, or a cell is no number or has no reason.
    """
    return [_reading_of(file.name, line, cells) for line, cells in _rows(file)]


def _rows(file: Path) -> Iterator[tuple[int, Mapping[str, str]]]:
    numbered = numbered_rows(file.name, read_bytes(file))
    header_line, header = read_header(file.name, numbered)
    for column in _REQUIRED:
        if column not in header:
            raise MissingEntryError(
                f"column {column} is missing; it is required", file=file.name, line=header_line
            )
    for part in parts(file.name, header, numbered, _MOST):
        for line, row in part:
            yield line, dict(zip(header, (cell.strip() for cell in row), strict=True))


def _reading_of(file: str, line: int, cells: Mapping[str, str]) -> NumbersAndReason:
    columns = ["config", *(_filled(cells, names) for names in (_READ_AGAINST, _NEST))]
    numbers = tuple(_number(file, line, column, cells[column]) for column in columns if column)
    reason = _on_one_line(read_text(cells["reason"]))
    if not 0 < len(reason) <= _LONGEST_REASON:
        raise BadValueError(
            f"a reason of 1 to {_LONGEST_REASON} characters is required",
            file=file,
            line=line,
            column="reason",
        )
    return numbers, reason


def _filled(cells: Mapping[str, str], names: tuple[str, ...]) -> str:
    """Return the first of some columns that says something in a row; "" where none does."""
    return next((name for name in names if cells.get(name)), "")


def _number(file: str, line: int, column: str, text: str) -> int:
    if _NUMBER.fullmatch(text) is None:
        raise BadValueError(f"{text!r} is not the number of a reading", file=file, line=line, column=column)
    return int(text)


def _on_one_line(reason: str) -> str:
    return " ".join(reason.split())
