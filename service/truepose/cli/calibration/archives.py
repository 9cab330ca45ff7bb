"""The command that computes a whole archive anew. Heavy imports wait until it runs."""

import contextlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from truepose.cli.exchange.files import Json, Workers, effect_names, writing
from truepose.cli.output import print_json, print_lines, shown_progress
from truepose.domain.errors import ConfigurationError

if TYPE_CHECKING:
    from truepose.analysis.archive.campaigns import Archived
    from truepose.analysis.archive.changes import Change
    from truepose.analysis.archive.run import Anew

_TABLE = "changes.csv"
_MOST_LINES = 40


def reanalyse_command(
    archive: Annotated[
        str,
        typer.Argument(help="Folder of campaign folders or zips, or a database (file, or sqlite:///file)."),
    ],
    out: Annotated[Path, typer.Option(help="Folder of the results; what it has is not computed again.")],
    effects: Annotated[
        str, typer.Option(help="`auto`, or names separated by commas, e.g. base,tool,geometry.")
    ] = "auto",
    against: Annotated[
        Path | None,
        typer.Option(help="Folder of results of an earlier version; by default --out, then the database."),
    ] = None,
    workers: Workers = None,
    json: Json = False,
) -> int:
    """Identify and diagnose every campaign of an archive anew, and say what is different from before.

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
def campaigns_of(archive: str) -> "Iterator[Sequence[Archived]]":
    """Offer the campaigns of a folder or a database; raises ConfigurationError, StorageError."""
    from truepose.analysis.archive.campaigns import in_database, in_folder

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
    campaigns: "Sequence[Archived]",
    out: Path,
    effects: tuple[str, ...] | None,
    against: Path | None,
    where: str | None,
) -> "Anew":
    from truepose.analysis.archive.run import Archive
    from truepose.analysis.cluster.chosen import workers
    from truepose.effects.registry import chosen_effects

    chosen_effects(effects or ())
    with writing(out):
        work = Archive(campaigns, out, effects, against)
    with workers(where, len(campaigns)) as cluster, shown_progress() as told:
        return work.compute(cluster, told)


def _write(file: Path, changes: "Sequence[Change]") -> None:
    import csv

    from truepose.analysis.archive.changes import table
    from truepose.exchange.tables.texts import written_text

    with writing(file), file.open("w", encoding="utf-8", newline="") as opened:
        csv.writer(opened).writerows(map(written_text, row) for row in table(changes))


def _lines(anew: "Anew", table: Path) -> Iterator[str]:
    differing = [row for row in anew.changes if row.differs]
    for row in differing[:_MOST_LINES]:
        yield f"{row.campaign}: {_told(row)}"
    if len(differing) > _MOST_LINES:
        yield f"{len(differing) - _MOST_LINES} more campaigns differ."
    for row in anew.failed:
        yield f"{row.campaign} has no result: {row.failed}"
    compared = sum(row.compared for row in anew.changes)
    yield (
        f"{len(anew.changes)} campaigns: {anew.computed} computed, {anew.there_already} were there already, "
        f"{len(anew.failed)} failed. Of {compared} with an earlier result {len(differing)} differ: {table}"
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


def _document(anew: "Anew", table: Path) -> dict[str, object]:
    import dataclasses

    return {
        "campaigns": len(anew.changes),
        "computed": anew.computed,
        "there_already": anew.there_already,
        "failed": {row.campaign: row.failed for row in anew.failed},
        "table": str(table),
        "differing": [dataclasses.asdict(row) for row in anew.changes if row.differs],
    }
