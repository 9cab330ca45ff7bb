"""Files and columns as they are shown, with what was done to them, and the first fault in its place."""

from collections.abc import Iterator, Sequence
from typing import Final

from truepose.exchange.errors import InputFileError
from truepose.exchange.import_wizard.columns import ImportedTable, ImportedValueError, labels_of
from truepose.exchange.import_wizard.dialogue import DetectedColumn, DetectedFile, DisplayedLine, Fault
from truepose.exchange.import_wizard.files import Piece
from truepose.exchange.import_wizard.sheet import cells_of, decode_text, lines_of
from truepose.exchange.import_wizard.tables import DetectedTable
from truepose.messages.message import Message, message

_AROUND: Final = 2
_WIDEST: Final = 400  # characters of a line that are shown


def in_its_file(error: InputFileError, table: ImportedTable) -> InputFileError:
    """Return an error of a table that was made, at the place where its row was brought."""
    if error.row is None:
        return error
    return ImportedValueError(error.sentence, table.places[error.row], error.column)


def display_fault(error: InputFileError, pieces: Sequence[Piece], sheets: Sequence[DetectedTable]) -> Fault:
    """Return a fault as it is shown, with the lines around it."""
    piece = next((one for one in pieces if one.name == error.file), None)
    if piece is None or error.line is None:
        return Fault(error.file, error.sentence, error.line)
    return Fault(error.file, error.sentence, error.line, _column(error, sheets), _lines(piece, error.line))


def _column(error: InputFileError, sheets: Sequence[DetectedTable]) -> int | None:
    found = next((one for one in sheets if one.sheet.name == error.file), None)
    if found is None or error.column is None:
        return None
    point = error.point if isinstance(error, ImportedValueError) else 0
    wanted = [at for at, one in enumerate(found.meanings) if one.column == error.column]
    return next((at for at in wanted if found.meanings[at].point in {0, point}), None)


def _lines(piece: Piece, line: int) -> tuple[DisplayedLine, ...]:
    sheet = piece.sheet
    lines = (
        sheet.lines if sheet is not None else tuple(lines_of(piece.name, decode_text(piece.name, piece.data)))
    )
    numbers = range(max(1, line - _AROUND), min(len(lines), line + _AROUND) + 1)
    return tuple(
        _line(number, lines[number - 1], None if sheet is None else sheet.separator) for number in numbers
    )


def _line(number: int, text: str, separator: str | None) -> DisplayedLine:
    # Lines may have 65,536 characters, and five of them go onto the page with each fault.
    short = text[:_WIDEST]
    return DisplayedLine(number, tuple(cells_of(short, separator)) if separator else (short,), short)


_SHOWN: Final = 5  # cells of a column
_WIDEST_TABLE: Final = 40  # characters of a cell
_MOST_LABELS: Final = 6


def files_seen(found: Sequence[Piece], sheets: Sequence[DetectedTable]) -> tuple[DetectedFile, ...]:
    """Return each file and what it is taken for."""
    by_name = {one.sheet.name: one for one in sheets}
    return tuple(_file(piece, by_name.get(piece.name)) for piece in found)


def _file(piece: Piece, one: DetectedTable | None) -> DetectedFile:
    if one is None:
        rows = 0 if piece.sheet is None else len(piece.sheet.rows)
        return DetectedFile(piece.name, piece.kind, reason=piece.why_not, rows=rows)
    return DetectedFile(
        piece.name,
        piece.kind,
        one.role,
        one.reason,
        len(one.sheet.rows),
        one.sheet.rows[0].line,
        tuple(_column_shown(one, at) for at in range(len(one.guesses))),
    )


def _column_shown(one: DetectedTable, at: int) -> DetectedColumn:
    guess = one.guesses[at]
    certainty = "said" if at in one.said_columns else guess.certainty
    cells = tuple(
        row.cells[at][:_WIDEST_TABLE] if at < len(row.cells) else "" for row in one.sheet.rows[:_SHOWN]
    )
    return DetectedColumn(one.sheet.header[at][:80], guess.meaning, certainty, guess.reason, cells)


def notes_on(sheets: Sequence[DetectedTable]) -> Iterator[Message]:
    """Say what was done to the tables without being asked."""
    for one in sheets:
        for at, meaning in enumerate(one.meanings):
            labels = labels_of(one.sheet, at) if meaning.quantity == "nest" else ()
            if 0 < len(labels) <= _MOST_LABELS:
                yield message("bring.note.labels", column=one.sheet.header[at], labels=", ".join(labels))
