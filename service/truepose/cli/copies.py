"""Options of services that copy their database while they run."""

from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.administration.durations import seconds
from truepose.storage.backup.plan import BackupPlan

BackupTo = Annotated[
    Path | None, typer.Option(help="Folder for copies of the database, made while the service runs.")
]
BackupEvery = Annotated[
    float, typer.Option(parser=seconds, help="Time between two copies.", metavar="90s|30m|24h|7d")
]
BackupKeep = Annotated[int, typer.Option(min=1, help="So many of the newest copies stay.")]
A_DAY_S = 24 * 3600.0
A_WEEK = 7  # copies


def wanted_copies(folder: Path | None, every_s: float, keep: int) -> BackupPlan | None:
    """Return what copies the options ask for."""
    return None if folder is None else BackupPlan(folder, every_s, keep)
