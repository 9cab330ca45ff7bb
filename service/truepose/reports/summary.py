"""Short text tables for a terminal: what the first screen of the report says."""

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from truepose.domain.results import Identification, NominalAndIdentified, Validation
from truepose.exchange.models.document import file_factor, file_unit
from truepose.reports.figures_rows import figures_rows
from truepose.reports.parameters.rows import is_held_by_prior
from truepose.reports.rounding import millimetres, rounded, uncertainty
from truepose.reports.truth import TrueParameter, truth_row
from truepose.words.catalogue import english


def identification_summary(identification: Identification) -> Group:
    """Return message, errors, parameters and what the data leave open."""
    parts: list[RenderableType] = [Text(english(identification.message))]
    if any(figures_rows(identification, None)):
        parts.append(figures_table(identification))
    if identification.parameters:
        parts.append(_parameter_table(identification))
    parts += [
        Text(f"Not told apart: {', '.join(group.parameters)}: {english(group.reason)}.")
        for group in identification.not_identifiable
    ]
    parts += [
        Text(f"No weight: configuration {outlier.config}, nest {outlier.nest}: {english(outlier.reason)}.")
        for outlier in identification.outliers
    ]
    return Group(*parts)


def validation_summary(validation: Validation) -> Group:
    """Return the errors of positions (or lengths) and of distances, and whether they pass."""
    table = _error_table(f"{validation.quantity.capitalize()} errors, mm")
    _add_pair(table, validation.quantity.capitalize(), validation.position)
    if validation.distance is not None:
        _add_pair(table, "Distance between points", validation.distance)
    return Group(table, Text(_verdict(validation)))


def _verdict(validation: Validation) -> str:
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


def figures_table(identification: Identification) -> Table:
    """Return nominal and identified errors [mm] side by side."""
    table = _error_table(f"{identification.quantity.capitalize()} errors, mm")
    for row in figures_rows(identification, None):
        _add_pair(table, row.label, row.pair)
    return table


def _error_table(title: str) -> Table:
    table = Table(title=title)
    table.add_column("readings")
    table.add_column("model")
    for name in ("n", "mean", "rms", "sd", "max", "noise"):
        table.add_column(name, justify="right")
    return table


def _add_pair(table: Table, label: str, pair: NominalAndIdentified) -> None:
    for first, model, figures in ((label, "nominal", pair.nominal), ("", "identified", pair.identified)):
        values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
        table.add_row(first, model, str(figures.n), *(millimetres(value) for value in values))


def _parameter_table(identification: Identification) -> Table:
    """Return what is added to the nominal values, as documents do; what only a prior holds stands out."""
    table = Table(title="Parameters, added to the nominal values")
    table.add_column("parameter")
    for name in ("value", "u"):
        table.add_column(name, justify="right")
    table.add_column("unit")
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


def truth_table(parameters: Iterable[TrueParameter]) -> Table:
    """Return identified parameters against true ones; deviations beyond 3 u stand out."""
    table = Table(title="Identified parameters against the simulator's truth")
    table.add_column("parameter")
    for name in ("identified", "true", "u", "unit", "deviation / u"):
        table.add_column(name, justify="left" if name == "unit" else "right")
    for row in map(truth_row, parameters):
        style = "yellow" if row.far else ""
        table.add_row(
            escape(row.name), row.identified, row.true, row.u, escape(row.unit), row.ratio, style=style
        )
    return table
