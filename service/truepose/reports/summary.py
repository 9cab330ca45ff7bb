"""Short text tables for a terminal: what the first screen of the report says."""

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from truepose.domain.results import Identification, NominalAndIdentified, Outlier, Validation
from truepose.exchange.models.document import file_factor, file_unit
from truepose.judgement.cautions import pose_test_caution
from truepose.judgement.iso9283.judged import PoseTest
from truepose.reports.figures_rows import figures_rows
from truepose.reports.parameters.rows import is_held_by_prior
from truepose.reports.rounding import millimetres, rounded, uncertainty
from truepose.reports.truth import TrueParameter, truth_row
from truepose.reports.validation.pose_test_rows import pose_test_rows, withheld_sentences
from truepose.words.catalogue import IN_ENGLISH, Catalogue, english

_DECIDED = {
    "conforms": "conforms",
    "does not conform": "does not conform",
    "cannot be decided": "cannot be decided: the readings are too uncertain for this limit",
}


def identification_summary(identification: Identification, words: Catalogue = IN_ENGLISH) -> Group:
    """Return message, errors, parameters and what the data leave open."""
    parts: list[RenderableType] = [Text(words.spoken(identification.message))]
    if any(figures_rows(identification, None)):
        parts.append(figures_table(identification, words))
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


def validation_summary(validation: Validation) -> Group:
    """Return the errors of positions (or lengths) and of distances, and whether they pass."""
    table = _error_table(f"{validation.quantity.capitalize()} errors, mm")
    _add_pair(table, validation.quantity.capitalize(), validation.position)
    if validation.relative is not None:
        _add_pair(table, "Relative: after alignment", validation.relative)
    if validation.distance is not None:
        _add_pair(table, "Distance between points", validation.distance)
    said = [verdict_sentence(validation), decision_sentence(validation)]
    return Group(table, *(Text(sentence) for sentence in said if sentence))


def pose_test_summary(test: PoseTest) -> Group:
    """Return the figures of ISO 9283 without their components, what is withheld, what they do not prove."""
    table = Table(title="ISO 9283:1998")
    for name in ("figure", "clause", "pose", "commanded by"):
        table.add_column(name)
    for name in ("value", "u"):
        table.add_column(name, justify="right")
    table.add_column("unit")
    table.add_column("noise alone", justify="right")
    for row in (row for row in pose_test_rows(test) if row.whole):
        table.add_row(
            row.name, row.clause, row.subject, row.commanded_by, row.value, row.u, row.unit, row.noise
        )
    withheld = (Text(f"Withheld: {sentence}") for sentence in withheld_sentences(test))
    return Group(table, *withheld, Text(english(pose_test_caution(test))))


def decision_sentence(validation: Validation) -> str:
    """Return whether the limit is kept with the uncertainty counted; nothing without a limit."""
    decided = validation.decision
    if decided is None:
        return ""
    if decided.rule == "simple":
        return f"By simple acceptance it {_DECIDED[decided.verdict]}; the uncertainty is not counted."
    return (
        f"With a guard band of {millimetres(decided.guard_mm)} mm (ISO 14253-1, 95 %) it "
        f"{_DECIDED[decided.verdict]}; the reading that decides is off by {millimetres(decided.error_mm)} mm."
    )


def verdict_sentence(validation: Validation) -> str:
    """Return whether the model passes, and by which measure."""
    if validation.limit_mm is None:
        return _without_limit(validation)
    verb = "stays within" if validation.passed else "exceeds"
    return f"The largest error {verb} the limit of {validation.limit_mm:g} mm."


def _without_limit(validation: Validation) -> str:
    if validation.passed:
        return (
            "The identified model's mean error is below the nominal one's and in keeping with what it claims."
        )
    if validation.position.identified.mean_mm > validation.position.nominal.mean_mm:
        return "The identified model's mean error is not below the nominal one's."
    return (
        f"The identified model's mean error is far above the {validation.claimed_mm:.3g} mm that it claims: "
        "the readings are of another robot, frame or unit, or the robot has changed."
    )


def figures_table(identification: Identification, words: Catalogue = IN_ENGLISH) -> Table:
    """Return nominal and identified errors [mm] side by side."""
    positions = identification.quantity == "position"
    title = words.say("terminal.position_errors" if positions else "terminal.length_errors")
    table = _error_table(title, words)
    for row in figures_rows(identification, None):
        _add_pair(table, words.spoken(row.label), row.pair, words)
    return table


def _error_table(title: str, words: Catalogue = IN_ENGLISH) -> Table:
    table = Table(title=title)
    table.add_column(words.say("curve.readings"))
    table.add_column(words.say("terminal.model"))
    mean, sd, noise = map(words.say, ("terminal.mean", "terminal.sd", "terminal.noise_column"))
    for name in ("n", mean, "rms", sd, "max", noise):
        table.add_column(name, justify="right")
    return table


def _add_pair(table: Table, label: str, pair: NominalAndIdentified, words: Catalogue = IN_ENGLISH) -> None:
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    for first, model, figures in ((label, nominal, pair.nominal), ("", identified, pair.identified)):
        values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
        table.add_row(first, model, str(figures.n), *(millimetres(value) for value in values))


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
