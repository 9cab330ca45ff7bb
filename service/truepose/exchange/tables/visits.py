"""A table that says of campaigns which robot was measured by what and on which day."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Final

from truepose.exchange.errors import BadValueError, MissingEntryError
from truepose.exchange.input_file import read_bytes
from truepose.exchange.tables.rows import MOST_ROWS, Numbered, numbered_rows, parts, read_header

_COLUMNS: Final = ("campaign", "robot", "instrument", "day")


@dataclass(frozen=True, slots=True)
class Stated:
    """Which robot was measured, by what and on which day; empty or None: nobody said."""

    robot: str = ""
    instrument: str = ""
    day: date | None = None

    def or_else(self, other: "Stated") -> "Stated":
        """Return this, and of `other` what this does not say."""
        return Stated(self.robot or other.robot, self.instrument or other.instrument, self.day or other.day)


NOT_STATED: Final = Stated()


def read_visits(file: Path) -> Mapping[str, Stated]:
    """Read `campaign, robot, instrument, day`; an empty cell says nothing.

    Raises
    ------
    InputFileError
        A column is missing, a day is none, or a campaign stands in two rows.
    """
    return visits_from(file.name, read_bytes(file))


def visits_from(name: str, data: bytes) -> Mapping[str, Stated]:
    """Read the content of a table called `name`; raises as `read_visits`."""
    found: dict[str, Stated] = {}
    for line, campaign, stated in _rows(name, numbered_rows(name, data)):
        if campaign in found:
            raise BadValueError(f"{campaign!r} stands in two rows", file=name, line=line, column="campaign")
        found[campaign] = stated
    return found


def _rows(name: str, numbered: Iterator[Numbered]) -> Iterator[tuple[int, str, Stated]]:
    header = read_header(name, numbered)
    for column in _COLUMNS:
        if column not in header:
            raise MissingEntryError(f"column {column} is missing; it is required", file=name, line=1)
    for part in parts(name, header, numbered, MOST_ROWS):
        for line, row in part:
            cells = dict(zip(header, (cell.strip() for cell in row), strict=True))
            stated = Stated(cells["robot"], cells["instrument"], _day(name, line, cells["day"]))
            yield line, cells["campaign"], stated


def _day(name: str, line: int, text: str) -> date | None:
    try:
        return date.fromisoformat(text) if text else None
    except ValueError as error:
        raise BadValueError(
            f"{text!r} is no day; one as 2026-03-03 is required", file=name, line=line, column="day"
        ) from error
