"""Errors of orientation as a reader sees them, in degrees: only where orientations were read."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.table import Table

from truepose.domain.results.identification import Identification, TurnPair, TurnStatistics
from truepose.reports.terminal.errors import error_table
from truepose.reports.wording.rounding import fixed
from truepose.words.catalogue import IN_ENGLISH, Catalogue

if TYPE_CHECKING:
    from truepose.domain.results.validation import Validation


@dataclass(frozen=True, slots=True)
class TurnsRow:
    """One line of the table of orientations."""

    label: str  # empty: as the line above
    model: str
    n: int
    values: tuple[str, ...]  # mean, RMS, standard deviation, largest, noise [deg]


def turns_rows(judged: "Identification | Validation", words: Catalogue) -> tuple[TurnsRow, ...]:
    """Return the lines; none where no orientations were read."""
    return tuple(row for label, pair in _pairs(judged) for row in _rows(words.say(label), pair, words))


def turns_table(judged: "Identification | Validation", words: Catalogue = IN_ENGLISH) -> Table | None:
    """Return the table for a terminal; None where no orientations were read."""
    rows = turns_rows(judged, words)
    if not rows:
        return None
    table = error_table("turns.title", words)
    for row in rows:
        table.add_row(row.label, row.model, str(row.n), *row.values)
    return table


def _pairs(judged: "Identification | Validation") -> Iterator[tuple[str, TurnPair]]:
    held_out = judged.validation_turns if isinstance(judged, Identification) else judged.turns
    calibration = judged.calibration_turns if isinstance(judged, Identification) else None
    for label, pair in (("turns.validation", held_out), ("turns.calibration", calibration)):
        if pair is not None:
            yield label, pair


def _rows(label: str, pair: TurnPair, words: Catalogue) -> Iterator[TurnsRow]:
    yield TurnsRow(label, words.say("model.nominal"), pair.nominal.n, _values(pair.nominal))
    yield TurnsRow("", words.say("model.identified"), pair.identified.n, _values(pair.identified))


def _values(turns: TurnStatistics) -> tuple[str, ...]:
    figures = (turns.mean_rad, turns.rms_rad, turns.sd_rad, turns.max_rad, turns.noise_rad)
    return tuple(fixed(math.degrees(one), 4, "deg") for one in figures)
