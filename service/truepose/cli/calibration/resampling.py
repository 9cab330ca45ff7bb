"""The command that fits a campaign again and again. Heavy imports wait until it runs."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.exchange.files import CampaignPath, Json, Workers, effect_names, read_measured
from truepose.cli.output import print_json, print_lines, print_tables, remark, shown_progress
from truepose.words.catalogue import english

if TYPE_CHECKING:
    from truepose.identification.resampling import Spread


class By(StrEnum):
    """What is drawn."""

    NOISE = "noise"
    CONFIGURATIONS = "configurations"


def resample_command(
    campaign: CampaignPath,
    by: Annotated[
        By,
        typer.Option(
            help="Noise as stated and priors as believed (Monte Carlo), or configurations with replacement "
            "(bootstrap).",
        ),
    ] = By.CONFIGURATIONS,
    draws: Annotated[int, typer.Option(min=10, max=1_000_000)] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same draws.")] = 0,
    effects: Annotated[
        str, typer.Option(help="`auto`, or names separated by commas, e.g. base,tool,geometry.")
    ] = "auto",
    workers: Workers = None,
    json: Json = False,
) -> int:
    """Say how far the parameters of a campaign scatter when it is fitted again and again.

    Example: truepose resample my-campaign --by noise --draws 2000 --workers dask://10.0.0.5:8786
    """
    from truepose.analysis.cluster.chosen import workers as chosen
    from truepose.analysis.resampled import TOGETHER, resampled

    names = effect_names(effects)
    measured = read_measured(campaign)
    remark(map(english, measured.ignored))
    with chosen(workers, -(-draws // TOGETHER)) as cluster, shown_progress() as told:
        spread = resampled(cluster, measured, names, by.value, draws, seed, told)
    if json:
        from truepose.exchange.results.resampling import resampling_document

        print_json(resampling_document(spread, measured.robot.name, seed))
    else:
        _show(spread)
    return 0


def _show(spread: "Spread") -> None:
    from rich.table import Table

    from truepose.exchange.results.resampling import in_units_of_files

    table = Table("parameter", "unit", "value", "u stated", "u of draws", "bias")
    for one in map(in_units_of_files, spread.parameters):
        sizes = (one.standard_uncertainty, one.standard_deviation, one.bias)
        table.add_row(one.name, one.unit, f"{one.value:.5g}", *(f"{size:.2g}" for size in sizes))
    print_tables(table)
    left = f", {spread.not_converged} left out, as they did not converge" if spread.not_converged else ""
    print_lines([f"{spread.draws} draws by {spread.way}{left}."])
