"""The first fault, shown in its place: the lines around it, and the cell."""

from collections.abc import Sequence
from typing import Final

from truepose.exchange.brought.columns import Brought, BroughtValueError
from truepose.exchange.brought.files.parcel import Piece
from truepose.exchange.brought.files.text import cells_of, decoded, lines_of
from truepose.exchange.brought.tables import Told
from truepose.exchange.brought.understood import Fault, LineShown
from truepose.exchange.errors import InputFileError

_AROUND: Final = 2
_WIDEST: Final = 400  # characters of a line that are shown


def in_its_file(error: InputFileError, table: Brought) -> InputFileError:
    """Return an error of a table that was made, at the place where its row was brought."""
    if error.row is None:
        return error
    return BroughtValueError(error.sentence, table.places[error.row], error.column)


def shown(error: InputFileError, pieces: Sequence[Piece], sheets: Sequence[Told]) -> Fault:
    """Return a fault as it is shown, with the lines around it."""
    piece = next((one for one in pieces if one.name == error.file), None)
    if piece is None or error.line is None:
        return Fault(error.file, error.sentence, error.line)
    return Fault(error.file, error.sentence, error.line, _column(error, sheets), _lines(piece, error.line))


def _column(error: InputFileError, sheets: Sequence[Told]) -> int | None:
    found = next((one for one in sheets if one.sheet.name == error.file), None)
    if found is None or error.column is None:
        return None
    point = error.point if isinstance(error, BroughtValueError) else 0
    wanted = [at for at, one in enumerate(found.meanings) if one.column == error.column]
    return next((at for at in wanted if found.meanings[at].point in {0, point}), None)


def _lines(piece: Piece, line: int) -> tuple[LineShown, ...]:
    sheet = piece.sheet
    lines = sheet.lines if sheet is not None else tuple(lines_of(piece.name, decoded(piece.name, piece.data)))
    numbers = range(max(1, line - _AROUND), min(len(lines), line + _AROUND) + 1)
    return tuple(
        _line(number, lines[number - 1], None if sheet is None else sheet.separator) for number in numbers
    )


def _line(number: int, text: str, separator: str | None) -> LineShown:
    short = text[:_WIDEST]
    return LineShown(number, tuple(cells_of(short, separator)) if separator else (short,), short)
