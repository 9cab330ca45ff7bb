"""Rows of a CSV text, within limits, and texts of people in it, of which none is a formula.

A spreadsheet computes a cell that begins with one of a few signs, whoever wrote it. Such a text is written
with an apostrophe before it, as OWASP has it, and a number never is. What is read loses the apostrophe again
exactly where one is written, so that every text comes back as it was.
"""

import csv
import io
import itertools
import re
from collections import Counter
from collections.abc import Iterator
from typing import Final, TypeAlias

from truepose.exchange.errors import BadValueError, UnreadableFileError

_BEGINS_FORMULA: Final = re.compile(
    "'*[=+\\-@\t\r\n\uff1d\uff0b\uff0d\uff20]"
)  # the wide ones compute as well
_NUMBER: Final = re.compile(r"\s*[+-]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+)(?:[eE][+-]?[0-9]+)?\s*")


def written_text(text: str) -> str:
    """Return a text as a cell that no spreadsheet computes."""
    return f"'{text}" if _is_formula(text) else text


def read_text(cell: str) -> str:
    """Return the text of a cell as `written_text` took it."""
    return cell[1:] if cell[:1] == "'" and _is_formula(cell[1:]) else cell


def _is_formula(text: str) -> bool:
    """Whether a text begins one, also behind apostrophes that it has itself."""
    return _BEGINS_FORMULA.match(text) is not None and _NUMBER.fullmatch(text.lstrip("'")) is None


# A hundred times the largest campaign that was seen; beyond it a fit would take more memory than there is.
MOST_ROWS: Final = 200_000
MOST_COLUMNS: Final = 500  # an arm of seven joints with everything that the format knows has 50
LONGEST_LINE: Final = 2**16
_ROWS_AT_A_TIME: Final = 4096
Numbered: TypeAlias = tuple[int, list[str]]  # line and cells of a row


def read_header(file: str, numbered: Iterator[Numbered]) -> Numbered:
    """Return the line of the first row, and the names of the columns in it, each of them once."""
    first = next(numbered, None)
    if first is None:
        raise UnreadableFileError("the file is empty; a header line and rows are required", file=file)
    line, header = first[0], [name.strip() for name in first[1]]
    if len(header) > MOST_COLUMNS:
        raise UnreadableFileError(
            f"{len(header)} columns exceed the limit of {MOST_COLUMNS}", file=file, line=line
        )
    _check_separator(file, line, header)
    twice = next((name for name, count in Counter(filter(None, header)).items() if count > 1), None)
    if twice is not None:
        raise BadValueError("the column appears twice; keep one", file=file, line=line, column=twice)
    return line, header


def parts(
    file: str, header: list[str], numbered: Iterator[Numbered], most_rows: int
) -> Iterator[list[Numbered]]:
    """Yield the rows, every one as long as the header, some thousand at a time."""
    total = 0
    while part := list(itertools.islice(numbered, _ROWS_AT_A_TIME)):
        total += len(part)
        # Counted as they come, so that a table which is too long is refused before all of it is in memory.
        if total > most_rows:
            raise UnreadableFileError(
                f"the file has more than {most_rows:,} rows, which is the limit", file=file
            )
        for line, row in part:
            if len(row) != len(header):
                raise UnreadableFileError(
                    f"{len(row)} cells found where the header has {len(header)} columns", file=file, line=line
                )
        yield part


def numbered_rows(file: str, data: bytes) -> Iterator[Numbered]:
    """Yield line number and cells of every line that is not blank."""
    # Strict: a quote that is never closed would take the rest of the file for one cell.
    reader = csv.reader(_lines(file, data), strict=True)
    line = 1
    try:
        for row in reader:
            if any(cell.strip() for cell in row):
                yield line, row
            # A quoted cell may go over several lines; the row is where it begins.
            line = reader.line_num + 1
    except csv.Error as error:
        raise UnreadableFileError(f"the line is not CSV ({error})", file=file, line=line) from error


def _lines(file: str, data: bytes) -> Iterator[str]:
    """Yield the lines of the text with their ends; nothing is copied but the line."""
    stream = io.TextIOWrapper(io.BytesIO(data), encoding="utf-8-sig", newline="")
    try:
        for number in itertools.count(1):
            # A file without line ends would otherwise be one line of 128 MB, and a cell of it.
            line = stream.readline(LONGEST_LINE + 1)
            if len(line) > LONGEST_LINE:
                raise UnreadableFileError(
                    f"the line has more than {LONGEST_LINE:,} characters", file=file, line=number
                )
            if not line:
                return
            yield line
    except UnicodeDecodeError as error:
        raise UnreadableFileError(
            "the text is not UTF-8; save the file as UTF-8", file=file, line=_line_of_fault(data)
        ) from error


def _line_of_fault(data: bytes) -> int:
    """Return the line of the first byte that is no text: the stream only knows where it is in its buffer."""
    try:
        data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return data.count(b"\n", 0, error.start) + 1
    return 1


def _check_separator(file: str, line: int, header: list[str]) -> None:
    # A table of one column with another separator in it: said in these words, since `column q1_deg is
    # missing` would send people looking for a column that they see.
    for mark, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(header) == 1 and mark in header[0]:
            raise UnreadableFileError(
                f"the columns are separated by {word}; commas are required, with . as decimal point",
                file=file,
                line=line,
            )
