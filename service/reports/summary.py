"""Short text tables for a terminal: what the first screen of the report says."""

from collections.abc import Iterable

from rich.markup import escape
from rich.table import Table

from service.domain.results import Identification
from service.reports.identification_report import figures_rows
from service.reports.rounding import millimetres
from service.reports.truth import TrueParameter, truth_row


def figures_table(identification: Identification) -> Table:
    """Return nominal and identified errors [mm] side by side."""
    table = Table(title=f"{identification.quantity.capitalize()} errors, mm")
    table.add_column("readings")
    table.add_column("model")
    for name in ("n", "mean", "rms", "sd", "max", "noise"):
        table.add_column(name, justify="right")
    for row in figures_rows(identification, None):
        for model, figures in (("nominal", row.pair.nominal), ("identified", row.pair.identified)):
            values = (figures.mean_mm, figures.rms_mm, figures.sd_mm, figures.max_mm, figures.noise_mm)
            label = row.label if model == "nominal" else ""
            table.add_row(label, model, str(figures.n), *(millimetres(value) for value in values))
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
