"""Short text tables for a terminal: what the first screen of the report says."""

from collections.abc import Iterable
from typing import Final

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from truepose.domain.results import (
    FigureUncertainty,
    Identification,
    NominalAndIdentified,
    Outlier,
    Statistics,
    UncertaintyPair,
    Validation,
    ValidationUncertainty,
)
from truepose.domain.sentences import Sentence, said
from truepose.exchange.models.document import file_factor, file_unit
from truepose.judgement.cautions import pose_test_caution
from truepose.judgement.iso9283.judged import PoseTest
from truepose.reports.figures_rows import figures_rows
from truepose.reports.parameters.rows import is_held_by_prior
from truepose.reports.rounding import millimetres, rounded, uncertainty
from truepose.reports.truth import TrueParameter, truth_row
from truepose.reports.turns import turns_table
from truepose.reports.validation.pose_test_rows import drift_sentences, pose_test_rows, withheld_sentences
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_DECIDED: Final = {
    ("simple", "conforms"): "validation.simple.conforms",
    ("simple", "does not conform"): "validation.simple.does_not_conform",
    ("guard band", "conforms"): "validation.guard_band.conforms",
    ("guard band", "does not conform"): "validation.guard_band.does_not_conform",
    ("guard band", "cannot be decided"): "validation.guard_band.undecided",
}


def identification_summary(identification: Identification, words: Catalogue = IN_ENGLISH) -> Group:
    """Return message, errors, parameters and what the data leave open."""
    parts: list[RenderableType] = [Text(words.spoken(identification.message))]
    if any(figures_rows(identification, None)):
        parts.append(figures_table(identification, words))
    turns = turns_table(identification, words)
    if turns is not None:
        parts.append(turns)
    if identification.parameters:
        parts.append(_parameter_table(identification, words))
    parts += [
        Text(words.say("terminal.open", parameters=group.parameters, reason=group.reason))
        for group in identification.not_identifiable
    ]
    parts += [Text(_without_weight(outlier, words)) for outlier in identification.outliers]
    return Group(*parts)


def _without_weight(outlier: Outlier, words: Catalogue) -> str:
    return words.say("terminal.no_weight", config=outlier.config, nest=outlier.nest, reason=outlier.reason)


def validation_summary(validation: Validation, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the errors of positions (or lengths) and of distances, and whether they pass."""
    positions = validation.quantity == "position"
    table = _error_table(_title(validation), words)
    label = words.say("validation.positions" if positions else "validation.lengths")
    known = validation.uncertainty or ValidationUncertainty()
    _add_pair(table, label, validation.position, words, known.position)
    if validation.relative is not None:
        _add_pair(table, words.say("validation.relative"), validation.relative, words, known.relative)
    if validation.distance is not None:
        _add_pair(table, words.say("validation.distances"), validation.distance, words, known.distance)
    told = verdict_sentence(validation), decision_sentence(validation)
    turns = turns_table(validation, words)
    tables = (table,) if turns is None else (table, turns)
    return Group(*tables, *(Text(words.spoken(sentence)) for sentence in told if sentence))


def pose_test_summary(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the figures of ISO 9283 without their components, what is withheld, what they do not prove."""
    table = Table(title="ISO 9283:1998")
    for key in ("terminal.figure", "terminal.clause", "terminal.pose", "terminal.commanded_by"):
        table.add_column(words.say(key))
    for name in (words.say("terminal.value"), "u"):
        table.add_column(name, justify="right")
    table.add_column(words.say("terminal.unit"))
    table.add_column(words.say("terminal.noise_alone"), justify="right")
    for row in (row for row in pose_test_rows(test, words) if row.whole):
        table.add_row(
            row.name, row.clause, row.subject, row.commanded_by, row.value, row.u, row.unit, row.noise
        )
    withheld = (
        Text(words.say("pose_test.withheld.line", sentence=sentence))
        for sentence in withheld_sentences(test, words)
    )
    drift = (Text(words.spoken(sentence)) for sentence in drift_sentences(test))
    return Group(table, *withheld, *drift, Text(words.spoken(pose_test_caution(test))))


def decision_sentence(validation: Validation) -> Sentence | None:
    """Return whether the limit is kept with the uncertainty counted; nothing without a limit."""
    decided = validation.decision
    if decided is None:
        return None
    return said(
        _DECIDED[decided.rule, decided.verdict],
        guard=millimetres(decided.guard_mm),
        error=millimetres(decided.error_mm),
    )


def verdict_sentence(validation: Validation) -> Sentence:
    """Return whether the model passes, and by which measure."""
    if validation.limit_mm is None:
        return _without_limit(validation)
    key = "validation.within_limit" if validation.passed else "validation.beyond_limit"
    return said(key, limit_mm=validation.limit_mm)


def _without_limit(validation: Validation) -> Sentence:
    if validation.passed:
        return said("validation.as_claimed")
    if validation.position.identified.mean_mm > validation.position.nominal.mean_mm:
        return said("validation.not_below")
    return said("validation.far_above", claimed_mm=validation.claimed_mm)


def figures_table(identification: Identification, words: Catalogue = IN_ENGLISH) -> Table:
    """Return nominal and identified errors [mm] side by side."""
    table = _error_table(_title(identification), words)
    for row in figures_rows(identification, None):
        _add_pair(table, words.spoken(row.label), row.pair, words)
    return table


def _title(judged: Identification | Validation) -> str:
    return "terminal.position_errors" if judged.quantity == "position" else "terminal.length_errors"


def _error_table(title: str, words: Catalogue) -> Table:
    table = Table(title=words.say(title))
    table.add_column(words.say("curve.readings"))
    table.add_column(words.say("terminal.model"))
    mean, sd, noise = map(words.say, ("terminal.mean", "terminal.sd", "terminal.noise_column"))
    for name in ("n", mean, "rms", sd, "max", noise):
        table.add_column(name, justify="right")
    return table


def _add_pair(
    table: Table,
    label: str,
    pair: NominalAndIdentified,
    words: Catalogue,
    known: UncertaintyPair | None = None,
) -> None:
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    _add_figures(table, (label, nominal), pair.nominal, None if known is None else known.nominal)
    _add_figures(table, ("", identified), pair.identified, None if known is None else known.identified)


def _add_figures(
    table: Table, names: tuple[str, str], figures: Statistics, known: FigureUncertainty | None
) -> None:
    values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
    table.add_row(*names, str(figures.n), *map(millimetres, values))
    if known is not None:
        each = (known.mean_mm, known.rms_mm, known.sd_mm, known.max_mm)
        table.add_row("", "", "u", *map(uncertainty, each), style="dim")


def _parameter_table(identification: Identification, words: Catalogue) -> Table:
    """Return what is added to the nominal values, as documents do; what only a prior holds stands out."""
    table = Table(title=words.say("terminal.parameters"))
    table.add_column(words.say("terminal.parameter"))
    for name in (words.say("terminal.value"), "u"):
        table.add_column(name, justify="right")
    table.add_column(words.say("terminal.unit"))
    for parameter in identification.parameters:
        factor = file_factor(parameter.unit)
        u = parameter.standard_uncertainty * factor
        table.add_row(
            escape(parameter.name),
            rounded(parameter.value * factor, u),
            uncertainty(u),
            file_unit(parameter.unit),
            style="yellow" if is_held_by_prior(parameter) else "",
        )
    return table


def truth_table(parameters: Iterable[TrueParameter], words: Catalogue = IN_ENGLISH) -> Table:
    """Return identified parameters against true ones; deviations beyond 3 u stand out."""
    table = Table(title=words.say("terminal.truth"))
    table.add_column(words.say("terminal.parameter"))
    for name in (words.say("terminal.identified"), words.say("terminal.true"), "u"):
        table.add_column(name, justify="right")
    table.add_column(words.say("terminal.unit"))
    table.add_column(words.say("terminal.deviation"), justify="right")
    for row in map(truth_row, parameters):
        style = "yellow" if row.far else ""
        table.add_row(
            escape(row.name), row.identified, row.true, row.u, escape(row.unit), row.ratio, style=style
        )
    return table
