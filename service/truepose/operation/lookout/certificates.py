"""How long the certificates of a cell still hold."""

from collections.abc import Iterator
from datetime import date

from truepose.domain.cell.artefacts import Artefact
from truepose.domain.cell.description import Cell


def days_left(cell: Cell, today: date) -> dict[str, int]:
    """Return the days until each certificate of a cell expires that says when; negative: it has."""
    return {
        artefact.name: (date.fromisoformat(artefact.certificate_expires) - today).days
        for artefact in _artefacts(cell)
        if artefact.certificate_expires
    }


def without_end(cell: Cell) -> tuple[str, ...]:
    """Return the artefacts of which nobody said until when their certificate holds."""
    return tuple(artefact.name for artefact in _artefacts(cell) if not artefact.certificate_expires)


def _artefacts(cell: Cell) -> Iterator[Artefact]:
    yield from (artefact for artefact in (cell.tool, cell.world) if artefact is not None)
    if cell.ballbar is not None:
        yield from (cell.ballbar.instrument, cell.ballbar.calibrator)
