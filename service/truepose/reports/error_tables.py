"""Tables of errors, each model a row: of positions or lengths in mm, of orientations in degrees."""

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final, TypeAlias

from truepose.domain.identification import (
    Identification,
    NominalAndIdentified,
    Statistics,
    TurnPair,
    TurnStatistics,
)
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.rounding import format_fixed, millimetres, uncertainty_mm
from truepose.reports.tables import Table, heads_of

if TYPE_CHECKING:
    from truepose.domain.diagnosis import Diagnosis
    from truepose.domain.validation import FigureUncertainty, UncertaintyPair, Validation

_MODELS: Final = ("model.nominal", "model.identified")
_FIGURES: Final = ("n", "report.mean", "RMS", "report.sd", "report.max", "report.noise_alone")
Row: TypeAlias = tuple[str, ...]  # readings, model, n, figures


def title_of(judged: "Identification | Validation | Diagnosis") -> str:
    """Return the key of what stands above the errors of positions, or of lengths."""
    return "terminal.position_errors" if judged.quantity == "position" else "terminal.length_errors"


def error_table(rows: Iterable[Row], words: Catalogue, of: str = "identification.readings") -> Table:
    """Return rows of `pair_rows` and `figures_row` under their heads; `of` is the key of the first.

    Rows of standard uncertainties, which have a `u` for the number of readings, stand back.
    """
    made = list(rows)
    dim = [number for number, row in enumerate(made) if row[2] == "u"]
    return Table(heads_of(words, of, "report.model", *_FIGURES), made, names=2, dim=dim)


def pair_rows(
    label: str, pair: NominalAndIdentified, words: Catalogue, known: "UncertaintyPair | None" = None
) -> Iterator[Row]:
    """Yield the figures of the nominal model and of the identified one, each before its uncertainty."""
    nominal, identified = map(words.say, _MODELS)
    yield figures_row(label, nominal, pair.nominal)
    if known is not None:
        yield _uncertainty_row(known.nominal)
    yield figures_row("", identified, pair.identified)
    if known is not None:
        yield _uncertainty_row(known.identified)


def figures_row(label: str, model: str, figures: Statistics) -> Row:
    """Return what a model errs by; an empty label: as the row above."""
    values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
    return (label, model, f"{figures.n:,}", *map(millimetres, values))


def _uncertainty_row(known: "FigureUncertainty") -> Row:
    return ("", "", "u", *map(uncertainty_mm, (known.mean_mm, known.rms_mm, known.sd_mm, known.max_mm)), "")


def turns_table(judged: "Identification | Validation", words: Catalogue = IN_ENGLISH) -> Table:
    """Return the errors of orientations; no row where none was read."""
    rows = (row for label, pair in _pairs(judged) for row in _turn_rows(words.say(label), pair, words))
    return error_table(rows, words)


def _pairs(judged: "Identification | Validation") -> Iterator[tuple[str, TurnPair]]:
    held_out = judged.validation_turns if isinstance(judged, Identification) else judged.turns
    calibration = judged.calibration_turns if isinstance(judged, Identification) else None
    for label, pair in (("turns.validation", held_out), ("turns.calibration", calibration)):
        if pair is not None:
            yield label, pair


def _turn_rows(label: str, pair: TurnPair, words: Catalogue) -> Iterator[Row]:
    nominal, identified = map(words.say, _MODELS)
    yield _turn_row(label, nominal, pair.nominal)
    yield _turn_row("", identified, pair.identified)


def _turn_row(label: str, model: str, turns: TurnStatistics) -> Row:
    figures = (turns.mean_rad, turns.rms_rad, turns.sd_rad, turns.max_rad, turns.noise_rad)
    return (label, model, f"{turns.n:,}", *(format_fixed(math.degrees(one), 4, "deg") for one in figures))
