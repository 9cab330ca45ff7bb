"""Tables of text: the same heads and rows on a page, in a notebook and on a terminal."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal, Self

from rich.markup import escape
from rich.table import Table as TerminalTable

from truepose.messages.catalogue import Catalogue


class Remarked(str):
    """A cell with a remark in small print; a terminal has no room for that."""

    remark: str

    def __new__(cls, text: str, remark: str) -> Self:
        """Take the text and what is remarked."""
        made = super().__new__(cls, text)
        made.remark = remark
        return made


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells under their heads."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    names: int = 0  # cells of a row, from the first, that are words; numbers follow
    strong: Collection[int] = ()  # rows that stand out
    dim: Collection[int] = ()  # rows that stand back

    def of_columns(self, *columns: int) -> "Table":
        """Return some of the columns, those of words first."""
        names = sum(column < self.names for column in columns)
        rows = [[row[column] for column in columns] for row in self.rows]
        return Table([self.heads[column] for column in columns], rows, names, self.strong, self.dim)


def heads_of(words: Catalogue, *keys: str) -> list[str]:
    """Return the heads of columns by their keys; symbols, which are no keys, are alike in every language."""
    return [words.say(key) if "." in key else key for key in keys]


def on_terminal(table: Table, title: str = "", *, narrow: bool = False) -> TerminalTable:
    """Return a table for a terminal; a narrow one has many columns, which are broken and stand close."""
    shown = TerminalTable(
        title=title or None, padding=0 if narrow else (0, 1), show_edge=False, pad_edge=False
    )
    for column, head in enumerate(table.heads):
        cells = [row[column] for row in table.rows]
        broken = escape(head.replace(", ", ",\n") if narrow else _in_lines(head, cells))
        side: Literal["left", "right"] = "left" if column < table.names else "right"
        shown.add_column(broken, justify=side, overflow="fold")  # too narrow, a word is broken and never cut
    styles = dict.fromkeys(table.dim, "dim") | dict.fromkeys(table.strong, "yellow")
    for number, row in enumerate(table.rows):
        shown.add_row(*map(escape, row), style=styles.get(number, ""))
    return shown


_SPARE = 4  # characters by which a head may be wider than what stands below it


def _in_lines(head: str, cells: Sequence[str]) -> str:
    """Return a head in two lines where it alone would make its column wide."""
    first, _, last = head.rpartition(" ")
    widest = max(map(len, cells), default=0)
    return f"{first}\n{last}" if len(last) > 1 and first and len(head) > widest + _SPARE else head
