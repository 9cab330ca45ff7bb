"""Sheets of a workbook (Office Open XML, ISO/IEC 29500-1) as text: each becomes a table of its own.

Only what cells hold is read. A formula counts as what it last came to; hidden sheets, pictures and looks are
passed over. A line of the text is a row of the sheet, so that a fault is found again in the program it is of.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from pathlib import PurePosixPath
from typing import Final
from xml.parsers import expat

from truepose.exchange.campaigns.zip_file import read_zip_files
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.tables.rows import MOST_COLUMNS, MOST_ROWS
from truepose.exchange.tables.table_reader import is_number
from truepose.exchange.xml_text import read_xml

SUFFIXES: Final = frozenset({".xlsx", ".xlsm"})
_MOST_CELLS: Final = 4_000_000
_MOST_CHARACTERS: Final = 2**26  # of all cells: a text that they share counts in each of them
_LONGEST_FORM: Final = 255  # characters of a form of numbers, by the spreadsheets themselves
_BOOK: Final = "xl/workbook.xml"
_CELL: Final = re.compile(r"([A-Z]{1,3})([1-9][0-9]{0,6})", re.ASCII)
_WHOLE: Final = re.compile(r"[0-9]{1,9}")
_TITLE: Final = re.compile(r"[^\w \-.]+")
# By their numbers (18.8.30).
_BUILT_IN_DATES: Final = frozenset(map(str, (*range(14, 23), *range(27, 37), 45, 46, 47, *range(50, 59))))
_NOT_OF_DATES: Final = re.compile(r'"[^"]*"|\\.|\[[^\]]*\]|General', re.IGNORECASE)
_OF_DATES: Final = re.compile(r"[dmyhs]", re.IGNORECASE)
# Spreadsheets take 1900 for a leap year: counted from here, days from March 1900 on are right.
_DAY_0: Final = datetime(1899, 12, 30, tzinfo=UTC)
_DAYS_OF_1904: Final = 1462  # books of old Macintoshes count from there
_LAST_DAY: Final = 2_958_465  # 9999-12-31


@dataclass(slots=True)
class _Book:
    """What all sheets of a workbook share."""

    parts: Mapping[str, bytes]
    name: str
    texts: list[str] = field(default_factory=list)
    dated: list[bool] = field(default_factory=list)  # by style
    from_1904: bool = False
    characters: int = 0  # of all cells so far

    def count(self, characters: int) -> None:
        """Count what cells hold; raises UnreadableFileError where it is more than is read."""
        self.characters += characters
        if self.characters > _MOST_CHARACTERS:
            raise UnreadableFileError("its cells have too much text", file=self.name)


def is_workbook(path: str, data: bytes) -> bool:
    """Whether a file is a workbook that is read here."""
    return PurePosixPath(path).suffix.lower() in SUFFIXES and data.startswith(b"PK")


def read_workbook(data: bytes, name: str) -> dict[str, bytes]:
    """Return the visible sheets of a workbook that hold anything, as text with tabs, by their names.

    Raises
    ------
    UnreadableFileError
        It is no workbook, is damaged or locked, or has more cells than are read.
    UnsafeArchiveError
        No honest program writes it.
    """
    book = _Book(read_zip_files(data, name), name)
    if _BOOK not in book.parts:
        raise UnreadableFileError("this is not a workbook; save the sheet as CSV and import that", file=name)
    book.texts = list(_shared_texts(book))
    book.dated = list(_dated_styles(book))
    found = {title: _text(_rows(book, part)) for title, part in _sheets(book)}
    stem = PurePosixPath(name).stem
    return {f"{stem} ({title}).txt": text for title, text in found.items() if text.strip()}


def _sheets(book: _Book) -> list[tuple[str, str]]:
    """Return title and part of each visible sheet, in the order of the book."""
    related: dict[str, str] = {}
    sheets: list[tuple[str, str]] = []

    def relation(tag: str, said: Mapping[str, str]) -> None:
        if tag == "Relationship":
            related[said.get("Id", "")] = said.get("Target", "")

    def sheet(tag: str, said: Mapping[str, str]) -> None:
        if tag == "workbookPr":
            book.from_1904 = said.get("date1904") in {"1", "true"}
        if tag == "sheet" and said.get("state", "visible") == "visible":
            # Targets are given from the part or from the root of the book, by the program that wrote it.
            target = related.get(said.get("id", ""), "").lstrip("/")
            part = target if target.startswith("xl/") else f"xl/{target}"
            if part.startswith("xl/worksheets/"):  # others are charts
                sheets.append((_TITLE.sub("_", said.get("name", ""))[:60], part))

    _read(book, "xl/_rels/workbook.xml.rels", relation)
    _read(book, _BOOK, sheet)
    if len({part for _, part in sheets}) < len(sheets):
        raise UnreadableFileError(
            "two sheets of the workbook refer to the same part of the file", file=book.name
        )
    return sheets


def _shared_texts(book: _Book) -> Iterator[str]:
    told: list[list[str]] = []
    within = [False, False]  # a text, its reading in another script

    def begin(tag: str, said: Mapping[str, str]) -> None:
        if tag == "si":
            told.append([])
        if tag in {"t", "rPh"}:
            within[tag == "rPh"] = True

    def end(tag: str) -> None:
        if tag in {"t", "rPh"}:
            within[tag == "rPh"] = False

    def letters(text: str) -> None:
        # Some books keep beside a text how it is read aloud (rPh), which is no part of the cell.
        if within == [True, False] and told:
            told[-1].append(text)

    if "xl/sharedStrings.xml" in book.parts:
        _read(book, "xl/sharedStrings.xml", begin, end, letters)
    return (" ".join("".join(parts).split()) for parts in told)


def _dated_styles(book: _Book) -> Iterator[bool]:
    """Return for each style whether numbers in it are days."""
    forms: dict[str, bool] = {}
    used: list[str] = []
    counting = [False]

    def begin(tag: str, said: Mapping[str, str]) -> None:
        if tag == "numFmt":
            forms[said.get("numFmtId", "")] = _is_of_dates(said.get("formatCode", ""))
        # Cells name entries of `cellXfs` by their place; `cellStyleXfs` before it holds entries of the same
        # form that no cell means.
        counting[0] = counting[0] or tag == "cellXfs"
        if tag == "xf" and counting[0]:
            used.append(said.get("numFmtId", "0"))

    def end(tag: str) -> None:
        counting[0] = counting[0] and tag != "cellXfs"

    if "xl/styles.xml" in book.parts:
        _read(book, "xl/styles.xml", begin, end)
    return (forms.get(one, one in _BUILT_IN_DATES) for one in used)


def _is_of_dates(code: str) -> bool:
    return _OF_DATES.search(_NOT_OF_DATES.sub("", code[:_LONGEST_FORM].split(";")[0])) is not None


class _Cells:
    """Collects the cells of a sheet while its part is read."""

    def __init__(self, book: _Book) -> None:
        self.rows: dict[int, dict[int, str]] = {}
        self._book = book
        self._place = (0, 0)
        self._said: Mapping[str, str] = {}
        self._value: list[str] = []
        self._formula = self._within = False

    def begin(self, tag: str, said: Mapping[str, str]) -> None:
        if tag == "row":
            self._place = (self._whole(said.get("r", str(self._place[0] + 1))), 0)
        elif tag == "c":
            self._place = self._placed(said.get("r"))
            self._said, self._value, self._formula = said, [], False
        self._formula = self._formula or tag == "f"
        self._within = tag in {"v", "t"}

    def letters(self, text: str) -> None:
        if self._within:
            self._value.append(text)

    def end(self, tag: str) -> None:
        self._within = False
        if tag == "c":
            self._keep("".join(self._value))

    def _placed(self, told: str | None) -> tuple[int, int]:
        found = None if told is None else _CELL.fullmatch(told)
        row, column = self._place[0], self._place[1] + 1
        if found is not None:
            row, column = int(found[2]), _column(found[1])
        return row, column

    def _keep(self, value: str) -> None:
        row, column = self._place
        if not value:
            # A program that writes a book without computing it leaves its formulas without values; an empty
            # cell would pass for one that nobody filled in.
            if self._formula:
                raise self._refused(
                    "a formula has no stored result; open the workbook in its spreadsheet program and save it"
                )
            return
        if not 0 < row <= MOST_ROWS or column > MOST_COLUMNS:
            raise self._refused("the sheet has too many cells")
        text = self._shown(value)
        self._book.count(len(text))
        # By place and not in a grid: two cells in far corners must not cost what lies between them (decision
        # 0055).
        self.rows.setdefault(row, {})[column] = text

    def _shown(self, value: str) -> str:
        """Return a cell as text: days as dates, all else as it is written."""
        kind, style = self._said.get("t", "n"), self._whole(self._said.get("s", "0"))
        dated = kind == "n" and self._book.dated[style : style + 1] == [True]
        if kind == "s":
            return self._shared(value)
        if dated and is_number(value):
            value = _date(float(value) + (_DAYS_OF_1904 if self._book.from_1904 else 0))
        return " ".join(value.split())

    def _shared(self, value: str) -> str:
        number = self._whole(value)
        if number >= len(self._book.texts):
            raise self._refused(f"a cell cannot be read: the workbook has no text {number}")
        return self._book.texts[number]

    def _whole(self, text: str) -> int:
        if not _WHOLE.fullmatch(text):
            raise self._refused(
                f"a cell cannot be read: {text[:30]!r} is not the number of a row, style or text"
            )
        return int(text)

    def _refused(self, sentence: str) -> UnreadableFileError:
        return UnreadableFileError(sentence, file=self._book.name, line=self._place[0])


def _column(letters: str) -> int:
    number = 0
    for letter in letters:
        number = 26 * number + ord(letter) - ord("A") + 1
    return number


def _date(days: float) -> str:
    if not 0 <= days <= _LAST_DAY:
        return str(days)
    moment = _DAY_0 + timedelta(milliseconds=round(days * 86_400_000))
    text = moment.replace(tzinfo=None).isoformat(timespec="milliseconds").removesuffix(".000")
    if days < 1:
        return text.partition("T")[2]
    return text.removesuffix("T00:00:00")


def _rows(book: _Book, part: str) -> list[list[str]]:
    """Return the rows of a sheet from its first one, with empty cells where there are none."""
    cells = _Cells(book)
    _read(book, part, cells.begin, cells.end, cells.letters)
    # Blank cells before others are text in the end, and count.
    if sum(max(row) for row in cells.rows.values()) > _MOST_CELLS:
        raise UnreadableFileError("the sheet has too many cells", file=book.name)
    rows = [cells.rows.get(number, {}) for number in range(1, max(cells.rows, default=0) + 1)]
    return [[row.get(column, "") for column in range(1, max(row, default=0) + 1)] for row in rows]


def _text(rows: list[list[str]]) -> bytes:
    return "\n".join("\t".join(map(_quoted, row)) for row in rows).encode()


def _quoted(cell: str) -> str:
    # As it stood, the quote would begin a quoted cell when the text is read as a table.
    return '"' + cell.replace('"', '""') + '"' if cell.startswith('"') else cell


def _read(
    book: _Book,
    part: str,
    begin: Callable[[str, Mapping[str, str]], None],
    end: Callable[[str], None] = lambda tag: None,
    letters: Callable[[str], None] = lambda text: None,
) -> None:
    """Read a part of a workbook, its names without their namespaces."""
    if part not in book.parts:
        raise UnreadableFileError(f"the workbook has no part {part}", file=book.name)
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.buffer_text = True
    parser.StartElementHandler = lambda tag, said: begin(_bare(tag), {_bare(k): v for k, v in said.items()})
    parser.EndElementHandler = lambda tag: end(_bare(tag))
    parser.CharacterDataHandler = letters
    read_xml(parser, book.name, book.parts[part], f"{part} of the workbook is damaged")


def _bare(tag: str) -> str:
    return tag.rpartition(" ")[2]
