"""The command that says whether a database holds what was written."""

from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines, shown_progress


def verify_command(
    file: Annotated[
        Path | None, typer.Argument(help="Database; by default the one in the user's data folder.")
    ] = None,
    json: Json = False,
) -> int:
    """Check every page and every record of a database, which may be in use. Status 1: something is wrong.

    Example: truepose verify truepose.sqlite3 --json
    """
    from truepose.settings import default_database_url
    from truepose.storage.connection.address import database_file
    from truepose.storage.integrity.arrival import verify_left

    database = database_file(default_database_url()) if file is None else file
    with shown_progress() as told:
        verdict = verify_left(database, lambda share: told(share, "records"))
    if json:
        print_json({
            "file": str(database),
            "whole": not verdict.findings,
            "records": verdict.records,
            "findings": list(verdict.findings),
            "newest_link": {"number": verdict.head[0], "hash": verdict.head[1]},
        })
    else:
        whole = f"{database}: {verdict.records} records, all as they were written."
        print_lines(verdict.findings or [whole])
    return 1 if verdict.findings else 0
