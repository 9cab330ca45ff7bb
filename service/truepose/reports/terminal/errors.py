"""The table of errors on a terminal: nominal and identified side by side, uncertainties below."""

from typing import TYPE_CHECKING

from rich.table import Table

from truepose.domain.results.identification import Identification, NominalAndIdentified, Statistics
from truepose.reports.wording.rounding import millimetres, uncertainty
from truepose.words.catalogue import Catalogue

if TYPE_CHECKING:
    from truepose.domain.results.validation import FigureUncertainty, UncertaintyPair, Validation


def title_of(judged: "Identification | Validation") -> str:
    """Return the key of what stands above the errors of positions, or of lengths."""
    return "terminal.position_errors" if judged.quantity == "position" else "terminal.length_errors"


def error_table(title: str, words: Catalogue) -> Table:
    """Return the table with its columns, still without a row."""
    table = Table(title=words.say(title))
    table.add_column(words.say("curve.readings"))
    table.add_column(words.say("terminal.model"))
    mean, sd, noise = map(words.say, ("terminal.mean", "terminal.sd", "terminal.noise_column"))
    for name in ("n", mean, "rms", sd, "max", noise):
        table.add_column(name, justify="right")
    return table


def add_pair(
    table: Table,
    label: str,
    pair: NominalAndIdentified,
    words: Catalogue,
    known: "UncertaintyPair | None" = None,
) -> None:
    """Add the figures of the nominal model and of the identified one."""
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    _add_figures(table, (label, nominal), pair.nominal, None if known is None else known.nominal)
    _add_figures(table, ("", identified), pair.identified, None if known is None else known.identified)


def _add_figures(
    table: Table, names: tuple[str, str], figures: Statistics, known: "FigureUncertainty | None"
) -> None:
    values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
    table.add_row(*names, str(figures.n), *map(millimetres, values))
    if known is not None:
        each = (known.mean_mm, known.rms_mm, known.sd_mm, known.max_mm)
        table.add_row("", "", "u", *map(uncertainty, each), style="dim")
