"""The command that says what may go, and removes it where it is told to."""

from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.administration.records import Url
from truepose.cli.exchange.files import Json
from truepose.cli.output import print_json, print_lines


def retention_command(
    database: Url = None,
    copies: Annotated[Path | None, typer.Option(help="Folder of 'truepose serve --backup-to'.")] = None,
    keep_copies: Annotated[int, typer.Option(min=1, help="So many of the newest stay.")] = 7,
    logs_days: Annotated[float, typer.Option(min=0, help="Rotated logs stay so long.")] = 90.0,
    drop: Annotated[bool, typer.Option("--drop", help="Remove it; without this it is only said.")] = False,
    json: Json = False,
) -> int:
    """Say what may be removed beside the database: old logs, surplus copies, what was left behind.

    Records stay for good: readings, acts, results, certificates, uploads. Live values are never stored.

    Example: truepose retention --copies backups --drop
    """
    from truepose.settings import default_database_url
    from truepose.storage.connection.address import database_file
    from truepose.storage.files.retention import Rules, surplus
    from truepose.storage.files.retention import drop as drop_surplus

    found = surplus(database_file(database or default_database_url()), Rules(logs_days, copies, keep_copies))
    if drop:
        drop_surplus(found)
    if json:
        files = [{"file": str(one.file), "bytes": one.size_bytes, "why": one.why} for one in found]
        print_json({"dropped": drop, "files": files, "bytes": sum(one.size_bytes for one in found)})
    else:
        word = "removed" if drop else "may go"
        print_lines([f"{one.file}: {word} ({one.why}, {one.size_bytes / 1e6:.1f} MB)" for one in found])
        print_lines([f"{len(found)} files {word}, {sum(one.size_bytes for one in found) / 1e6:.1f} MB."])
    return 0
