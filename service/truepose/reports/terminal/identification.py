"""An identification on a terminal, and the truth beside it where somebody knows it."""

from collections.abc import Iterable

from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from truepose.domain.results.identification import Identification, Outlier
from truepose.exchange.models.document import file_factor, file_unit
from truepose.reports.figures_rows import figures_rows
from truepose.reports.parameters.rows import is_held_by_prior
from truepose.reports.terminal.errors import add_pair, error_table, title_of
from truepose.reports.truth import TrueParameter, truth_row
from truepose.reports.wording.rounding import rounded, uncertainty
from truepose.reports.wording.turns import turns_table
from truepose.words.catalogue import IN_ENGLISH, Catalogue


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


def figures_table(identification: Identification, words: Catalogue = IN_ENGLISH) -> Table:
    """Return nominal and identified errors [mm] side by side."""
    table = error_table(title_of(identification), words)
    for row in figures_rows(identification, None):
        add_pair(table, words.spoken(row.label), row.pair, words)
    return table


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
