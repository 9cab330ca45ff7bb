"""Commands on many readings: a whole archive anew, what comes into a folder, draws of one campaign.

Heavy imports wait until one runs.
"""

import contextlib
import time
from collections.abc import Iterator, Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.files import (
    CampaignPath,
    Effects,
    Json,
    Workers,
    effect_names,
    read_measured,
    writing,
)
from truepose.cli.output import print_json, print_lines, print_tables, progress_bar, remark
from truepose.domain.errors import ConfigurationError, TrueposeError
from truepose.messages.catalogue import english

if TYPE_CHECKING:
    from truepose.analysis.archive import ArchivedCampaign, ReanalysisResult
    from truepose.analysis.archive_outcomes import Change
    from truepose.exchange.campaigns.points_with_joints import Arrival
    from truepose.identification.resampling import Spread


_TABLE = "changes.csv"
_MOST_LINES = 40


def reanalyse_command(
    archive: Annotated[
        str,
        typer.Argument(help="Folder of campaign folders or zips, or a database (file, or sqlite:///file)."),
    ],
    out: Annotated[Path, typer.Option(help="Folder for results; existing results are not computed again.")],
    effects: Effects = "auto",
    against: Annotated[
        Path | None,
        typer.Option(help="Folder of results of an earlier version (default: --out, then the database)."),
    ] = None,
    workers: Workers = None,
    json: Json = False,
) -> int:
    """Reanalyse every campaign of an archive, and report differences from earlier results.

    It may be interrupted and started again. Status 1: a campaign has no result; the table says why.

    Example: truepose reanalyse campaigns --out results --workers dask://10.0.0.5:8786
    """
    names = effect_names(effects)
    with campaigns_of(archive) as campaigns:
        anew = _computed(campaigns, out, names, against, workers)
    table = out / _TABLE
    _write(table, anew.changes)
    if json:
        print_json(_document(anew, table))
    else:
        print_lines(_lines(anew, table))
    return 1 if anew.failed else 0


@contextlib.contextmanager
def campaigns_of(archive: str) -> "Iterator[Sequence[ArchivedCampaign]]":
    """Offer the campaigns of a folder or a database; raises ConfigurationError, StorageError."""
    from truepose.analysis.archive import in_database, in_folder

    path = Path(archive)
    if path.is_dir():
        yield in_folder(path)
        return
    if "://" not in archive and not path.is_file():
        raise ConfigurationError(f"{archive}: there is no such folder or database.")
    url = archive if "://" in archive else f"sqlite:///{path.resolve()}"
    with in_database(url) as campaigns:
        yield campaigns


def _computed(
    campaigns: "Sequence[ArchivedCampaign]",
    out: Path,
    effects: tuple[str, ...] | None,
    against: Path | None,
    where: str | None,
) -> "ReanalysisResult":
    from truepose.analysis.archive import Archive
    from truepose.analysis.parallel.local_pool import workers
    from truepose.effects.registry import chosen_effects

    chosen_effects(effects or ())
    with writing(out):
        work = Archive(campaigns, out, effects, against)
    with workers(where, len(campaigns)) as cluster, progress_bar() as told:
        return work.compute(cluster, told)


def _write(file: Path, changes: "Sequence[Change]") -> None:
    import csv

    from truepose.analysis.archive_outcomes import table
    from truepose.exchange.tables.rows import written_text

    with writing(file), file.open("w", encoding="utf-8", newline="") as opened:
        csv.writer(opened).writerows(map(written_text, row) for row in table(changes))


def _lines(anew: "ReanalysisResult", table: Path) -> Iterator[str]:
    differing = [row for row in anew.changes if row.differs]
    for row in differing[:_MOST_LINES]:
        yield f"{row.campaign}: {_told(row)}"
    if len(differing) > _MOST_LINES:
        yield f"{len(differing) - _MOST_LINES} more campaigns differ."
    for row in anew.failed:
        yield f"{row.campaign} has no result: {row.failed}"
    compared = sum(row.compared for row in anew.changes)
    yield (
        f"{len(anew.changes)} campaigns: {anew.computed} computed, {anew.there_already} already present, "
        f"{len(anew.failed)} failed. Of {compared} with an earlier result, {len(differing)} differ: {table}"
    )


def _told(row: "Change") -> str:
    parts = []
    if row.status_before != row.status_now:
        parts.append(f"{row.status_before or 'not identified'} -> {row.status_now}")
    if row.verdict_before != row.verdict_now:
        parts.append(f"{row.verdict_before or 'not diagnosed'} -> {row.verdict_now}")
    if row.mean_before_um is not None and row.mean_now_um is not None:
        parts.append(f"mean error {row.mean_before_um:.2f} -> {row.mean_now_um:.2f} um")
    if row.changed_by_u is not None:
        parts.append(f"{row.parameter} by {row.changed_by_u:.2g} standard uncertainties")
    parts += [f"no longer {row.causes_gone}"] if row.causes_gone else []
    parts += [f"now {row.causes_new}"] if row.causes_new else []
    return ", ".join(parts)


def _document(anew: "ReanalysisResult", table: Path) -> dict[str, object]:
    import dataclasses

    return {
        "campaigns": len(anew.changes),
        "computed": anew.computed,
        "there_already": anew.there_already,
        "failed": {row.campaign: row.failed for row in anew.failed},
        "table": str(table),
        "differing": [dataclasses.asdict(row) for row in anew.changes if row.differs],
    }


_LOOK_S = 2.0  # between two looks: what is the same at both is whole


def watch_command(
    folder: Annotated[
        Path, typer.Argument(help="Folder to watch for new campaigns, or for points with joint angles.")
    ],
    out: Annotated[
        Path, typer.Option(help="Folder for the results: answer, model and report of each campaign.")
    ],
    once: Annotated[
        bool, typer.Option("--once", help="Process the files that are there now, then exit.")
    ] = False,
) -> int:
    """Identify each campaign that arrives in a folder, until interrupted; status 1: one of them failed.

    Example: truepose watch inbox --out results
    """
    if not folder.is_dir():
        raise ConfigurationError(f"{folder} is not a folder; create it first.")
    out.mkdir(parents=True, exist_ok=True)
    good = [_taken(arrival, out) for arrival in _whole(folder, once=once)]
    return 0 if all(good) else 1


def _whole(folder: Path, *, once: bool) -> Iterator["Arrival"]:
    """Yield each arrival once, when two looks found it alike; with `once` those of the first."""
    from truepose.exchange.campaigns.points_with_joints import arrivals

    if once:
        yield from arrivals(folder)
        return
    before: set[Arrival] = set()
    taken: set[Arrival] = set()
    while True:
        here = set(arrivals(folder))
        for arrival in sorted((here & before) - taken, key=lambda one: one.name):
            taken.add(arrival)
            yield arrival
        before = here
        time.sleep(_LOOK_S)


def _taken(arrival: "Arrival", out: Path) -> bool:
    """Identify, and say in one line what came of it; returns whether it went well."""
    from truepose.exchange.campaigns.folder import write_campaign
    from truepose.exchange.json_text import render_json
    from truepose.exchange.models.file import write_model
    from truepose.exchange.results.identification import identification_document
    from truepose.identification import identify
    from truepose.messages.catalogue import english
    from truepose.reports.identification.report import IdentificationReport

    place = out / arrival.name
    try:
        campaign = arrival.read()
        answer = identify(campaign)
    except TrueposeError as error:
        print_lines([f"{arrival.name}: {error}"])
        return False
    place.mkdir(exist_ok=True)
    write_campaign(campaign, place / "campaign")
    document = identification_document(answer, campaign.robot.name)
    (place / "identification.json").write_text(render_json(document) + "\n", encoding="utf-8")
    IdentificationReport(answer, campaign).write(place / "report.html")
    if answer.model is not None:
        write_model(answer.model, place / "model.json")
    print_lines([f"{arrival.name}: {english(answer.message)} {place / 'report.html'}"])
    return answer.model is not None


class ResamplingUnit(StrEnum):
    """What is drawn."""

    NOISE = "noise"
    CONFIGURATIONS = "configurations"


def resample_command(
    campaign: CampaignPath,
    by: Annotated[
        ResamplingUnit,
        typer.Option(
            help="Draw noise and priors as stated (Monte Carlo), or configurations with replacement "
            "(bootstrap).",
        ),
    ] = ResamplingUnit.CONFIGURATIONS,
    draws: Annotated[int, typer.Option(min=10, max=1_000_000)] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same draws.")] = 0,
    effects: Effects = "auto",
    workers: Workers = None,
    json: Json = False,
) -> int:
    """Estimate the scatter of a campaign's parameters by refitting resampled readings.

    Example: truepose resample my-campaign --by noise --draws 2000 --workers dask://10.0.0.5:8786
    """
    from truepose.analysis.parallel.local_pool import workers as chosen
    from truepose.analysis.resampling import TOGETHER, resample_parameters

    names = effect_names(effects)
    measured = read_measured(campaign)
    remark(map(english, measured.ignored))
    with chosen(workers, -(-draws // TOGETHER)) as cluster, progress_bar() as told:
        spread = resample_parameters(cluster, measured, names, by.value, draws, seed, told)
    if json:
        from truepose.exchange.results.identification import resampling_document

        print_json(resampling_document(spread, measured.robot.name, seed))
    else:
        _show(spread)
    return 0


def _show(spread: "Spread") -> None:
    from truepose.exchange.results.identification import SpreadDocument
    from truepose.reports.tables import Table, on_terminal

    rows = []
    for one in map(SpreadDocument.of, spread.parameters):
        sizes = (one.standard_uncertainty, one.standard_deviation, one.bias)
        rows.append([one.name, one.unit, f"{one.value:.5g}", *(f"{size:.2g}" for size in sizes)])
    heads = ("parameter", "unit", "value", "u stated", "u of draws", "bias")
    print_tables(on_terminal(Table(heads, rows, names=2)))
    left = f", {spread.not_converged} left out because they did not converge" if spread.not_converged else ""
    print_lines([f"{spread.draws} draws by {spread.way}{left}."])
