"""Files and columns as they are shown, with what was done to them without being asked."""

from collections.abc import Iterator, Sequence
from typing import Final

from truepose.domain.sentences import Sentence, said
from truepose.exchange.brought.columns import labels_of
from truepose.exchange.brought.files.parcel import Piece
from truepose.exchange.brought.tables import Told
from truepose.exchange.brought.understood import ColumnSeen, FileSeen

_SHOWN: Final = 5  # cells of a column
_WIDEST: Final = 40  # characters of a cell
_MOST_LABELS: Final = 6


def files_seen(found: Sequence[Piece], sheets: Sequence[Told]) -> tuple[FileSeen, ...]:
    """Return each file and what it is taken for."""
    by_name = {one.sheet.name: one for one in sheets}
    return tuple(_file(piece, by_name.get(piece.name)) for piece in found)


def _file(piece: Piece, one: Told | None) -> FileSeen:
    if one is None:
        rows = 0 if piece.sheet is None else len(piece.sheet.rows)
        return FileSeen(piece.name, piece.kind, reason=piece.why_not, rows=rows)
    return FileSeen(
        piece.name,
        piece.kind,
        one.role,
        one.reason,
        len(one.sheet.rows),
        one.sheet.rows[0].line,
        tuple(_column(one, at) for at in range(len(one.guesses))),
    )


def _column(one: Told, at: int) -> ColumnSeen:
    guess = one.guesses[at]
    certainty = "said" if at in one.said_columns else guess.certainty
    cells = tuple(row.cells[at][:_WIDEST] if at < len(row.cells) else "" for row in one.sheet.rows[:_SHOWN])
    return ColumnSeen(one.sheet.header[at][:80], guess.meaning, certainty, guess.reason, cells)


def notes_on(sheets: Sequence[Told]) -> Iterator[Sentence]:
    """Say what was done to the tables without being asked."""
    for one in sheets:
        for at, meaning in enumerate(one.meanings):
            labels = labels_of(one.sheet, at) if meaning.quantity == "nest" else ()
            if 0 < len(labels) <= _MOST_LABELS:
                yield said("bring.note.labels", column=one.sheet.header[at], labels=", ".join(labels))
