"""An identification on a terminal, and the truth beside it where a simulator knows it."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from rich.console import Group, RenderableType
from rich.text import Text

from truepose.domain.identification import Identification, Statistics
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text as Said
from truepose.reports.cause_words import printed_unit
from truepose.reports.error_tables import title_of, turns_table
from truepose.reports.identification.judged_figures import figures_table
from truepose.reports.identification.parameters import is_held_by_prior, parameter_cells, parameter_table
from truepose.reports.rounding import MISSING, format_rounded, uncertainty
from truepose.reports.tables import Table, heads_of, on_terminal
from truepose.validation.outcome import outcome_of

_K_95 = 1.96  # two-sided 95 % of the normal distribution
_FAR = 3.0  # standard uncertainties at which a deviation catches the eye


@dataclass(frozen=True, slots=True)
class TrueParameter:
    """A parameter as identified and as it truly is, in the unit that documents use (angles in deg)."""

    name: str
    identified: float
    true: float
    standard_uncertainty: float
    unit: str

    @property
    def deviation(self) -> float:
        """Identified minus true."""
        return self.identified - self.true

    @property
    def normalised(self) -> float:
        """Deviation over its standard uncertainty; NaN where none is stated."""
        return self.deviation / self.standard_uncertainty if self.standard_uncertainty > 0.0 else math.nan


@dataclass(frozen=True, slots=True)
class Truth:
    """True parameters and true errors: distances between predicted and true positions [mm]."""

    parameters: tuple[TrueParameter, ...] = ()
    errors: tuple[tuple[Said, Statistics], ...] = ()  # label such as "absolute" or "after rigid alignment"

    @property
    def covered_95(self) -> int:
        """How many parameters lie within their stated 95 % interval."""
        return sum(abs(parameter.normalised) <= _K_95 for parameter in self.parameters)


def truth_table(parameters: Iterable[TrueParameter], words: Catalogue = IN_ENGLISH) -> Table:
    """Return identified parameters against true ones, to the place of u; deviations beyond 3 u stand out."""
    known = tuple(parameters)
    far = [row for row, parameter in enumerate(known) if abs(parameter.normalised) > _FAR]
    keys = ("report.parameter", "truth.identified", "truth.true", "u", "report.unit", "truth.deviation")
    return Table(heads_of(words, *keys), [_truth_row(one, words) for one in known], 1, strong=far)


def _truth_row(parameter: TrueParameter, words: Catalogue) -> tuple[str, ...]:
    u, unit, ratio = parameter.standard_uncertainty, parameter.unit, parameter.normalised
    return (
        parameter.name,
        format_rounded(parameter.identified, u, unit),
        format_rounded(parameter.true, u, unit),
        uncertainty(u, unit),
        printed_unit(words.units.conversion(unit).symbol),
        words.units.formatted(ratio, "+.1f", "") if math.isfinite(ratio) else MISSING,
    )


def identification_summary(identification: Identification, words: Catalogue = IN_ENGLISH) -> Group:
    """Return message, errors, parameters and what the data leave open, for a terminal."""
    return Group(*_summary(identification, words))


def _summary(identification: Identification, words: Catalogue) -> Iterator[RenderableType]:
    yield Text(words.spoken(outcome_of(identification)))
    yield Text(words.spoken(identification.message))
    errors, turns = figures_table(identification, words), turns_table(identification, words)
    if errors.rows:
        yield on_terminal(errors, words.say(title_of(identification)))
    if turns.rows:
        yield on_terminal(turns, words.say("turns.title"))
    if identification.parameters:
        yield on_terminal(added_table(identification, words), words.say("terminal.parameters"))
    for group in identification.not_identifiable:
        yield Text(words.say("terminal.open", parameters=group.parameters, reason=group.reason))
    for one in identification.outliers:
        yield Text(words.say("terminal.no_weight", config=one.config, nest=one.nest, reason=one.reason))


def added_table(identification: Identification, words: Catalogue) -> Table:
    """Return what is added to the nominal values, as documents do; what only a prior holds stands out."""
    held = [row for row, one in enumerate(identification.parameters) if is_held_by_prior(one)]
    rows = (parameter_cells(one, one.value, words) for one in identification.parameters)
    return replace(parameter_table(rows, words).of_columns(1, 2, 3, 4), strong=held)
