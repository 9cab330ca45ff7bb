"""The commands around the database: is it as it was written, a copy of it, a copy put back, what may go."""

from pathlib import Path
from typing import Annotated

import typer

from truepose.cli.files import Json
from truepose.cli.output import print_json, print_lines, progress_bar

Url = Annotated[
    str | None,
    typer.Option(
        "--database",
        help="URL of the database, as 'truepose serve' has it; by default the one in the user's data folder.",
    ),
]
_SERVICE_FAILED = 3
_NO_PINS = "Copies contain no PINs: users set a new one at /account with their password."


def verify_command(
    file: Annotated[
        str | None,
        typer.Argument(help="Database, a file or a URL; by default the one in the user's data folder."),
    ] = None,
    head: Annotated[
        str | None, typer.Option(help="Chain head printed on a report: check that all its records are there.")
    ] = None,
    json: Json = False,
) -> int:
    """Check every page and record of a database, which may be in use; status 1: something is wrong.

    Example: truepose verify truepose.sqlite3 --head 4711-K3QF-7ZWD-M2PA-XY5R --json
    """
    from truepose.storage.engine.address import display_address
    from truepose.storage.integrity.head_hash import read_head
    from truepose.storage.integrity.verification import verify_left_at

    url = _address(file)
    database = file if file is not None and "://" not in file else display_address(url)
    printed = None if head is None else read_head(head)
    with progress_bar() as told:
        verdict = verify_left_at(url, lambda share: told(share, "records"), printed)
    newest = "" if verdict.head is None else verdict.head.text
    if json:
        print_json({
            "file": database,
            "whole": not verdict.findings,
            "records": verdict.records,
            "findings": list(verdict.findings),
            "newest_link": {"number": verdict.newest[0], "hash": verdict.newest[1]},
            "head": newest or None,
        })
    else:
        whole = (
            f"{database}: {verdict.records} records, none changed since it was written. Chain head {newest}."
        )
        print_lines(verdict.findings or [whole])
    return 1 if verdict.findings else 0


def backup_command(
    file: Annotated[Path, typer.Argument(help="File for the copy.")],
    database: Url = None,
    replace: Annotated[bool, typer.Option("--replace", help="Overwrite an earlier copy.")] = False,
    json: Json = False,
) -> int:
    """Copy the database into one file while the service runs, and verify the copy.

    Example: truepose backup backups/monday.sqlite3 --database sqlite:///cell.db
    """
    from truepose.storage.backup.schedule import back_up_at
    from truepose.storage.engine.address import display_address

    source = _url(database)
    with progress_bar() as told:
        made = back_up_at(source, file, told, replace=replace)
    if json:
        print_json({
            "file": str(made.file),
            "database": display_address(source),
            "bytes": made.size_bytes,
            "records": made.head.links,
            "head": made.head.text,
            "drafts": made.drafts,
        })
    else:
        beside = f" {made.drafts} drafts are stored beside it." if made.drafts else ""
        print_lines([
            f"{made.file}: {made.head.links} records, {made.size_bytes / 1e6:.1f} MB, verified. "
            f"Chain head {made.head.text}.{beside}"
        ])
    return 0


def restore_command(
    file: Annotated[Path, typer.Argument(help="Copy that 'truepose backup' made.")],
    database: Url = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="Replace the present database, and keep it under another name.")
    ] = False,
    at_next_start: Annotated[
        bool,
        typer.Option(
            "--at-next-start", help="Restore at the next start of the service, which may be running now."
        ),
    ] = False,
    json: Json = False,
) -> int:
    """Restore the database from a copy, now or at the next start of a running service.

    Every record of the copy is verified before anything is touched. Status 3: a service uses the database.

    Example: truepose restore backups/monday.sqlite3 --database sqlite:///cell.db --replace --at-next-start
    """
    from truepose.cli.output import remark
    from truepose.storage.backup.copying import restore_drafts
    from truepose.storage.backup.schedule import restore_at
    from truepose.storage.engine.address import database_file, display_address, is_server, parsed_url
    from truepose.storage.engine.reading import lies_beside
    from truepose.storage.errors import BackupError, DatabaseInUseError

    url = _url(database)
    server = is_server(parsed_url(url))
    if at_next_start:
        if server:
            raise BackupError(
                "--at-next-start does not work for a database server; restore into an empty database there."
            )
        return _lay_ready(file, database_file(url), replace=replace, json=json)
    try:
        with progress_bar() as told:
            head, aside = restore_at(file, url, told, replace=replace)
    except DatabaseInUseError as error:
        let_it_run = (
            "Or keep it running: --at-next-start verifies the copy now and restores it at the next start."
        )
        remark([str(error) if server else f"{error} {let_it_run}"])
        return _SERVICE_FAILED
    drafts = restore_drafts(file, lies_beside(url))
    kept = None if aside is None else str(aside)
    if json:
        print_json({
            "database": display_address(url),
            "records": head.links,
            "head": head.text,
            "kept": kept,
            "drafts": drafts,
        })
    else:
        before = "" if kept is None else f" The previous database is kept as {kept}."
        brought = f" {drafts} drafts are back." if drafts else ""
        print_lines([
            f"{display_address(url)}: {head.links} records restored. Chain head {head.text}."
            f"{before}{brought} {_NO_PINS}"
        ])
    return 0


def _lay_ready(file: Path, target: Path, *, replace: bool, json: bool) -> int:
    from truepose.storage.backup.restoring import lay_ready

    with progress_bar() as told:
        head, ready = lay_ready(file, target, told, replace=replace)
    if json:
        waits = {"database": str(target), "records": head.links, "head": head.text, "waits": str(ready)}
        print_json(waits)
    else:
        print_lines([
            f"{ready}: {head.links} records, verified. Chain head {head.text}. Restart the "
            "service to switch to them; its present database is kept beside them. To cancel, delete this "
            f"file. {_NO_PINS}"
        ])
    return 0


def copy_command(
    source: Annotated[str, typer.Argument(help="Database to copy, a file or a URL.")],
    target: Annotated[str, typer.Argument(help="Empty database to copy to, a file or a URL.")],
    json: Json = False,
) -> int:
    """Copy a database from a file to a PostgreSQL server, or back, with all records and links.

    No service may use either database. All records are copied and verified, or none. Status 3: one is in use.

    Example: truepose copy truepose.sqlite3 postgresql://truepose@localhost/truepose --json
    """
    from truepose.cli.output import remark
    from truepose.storage.backup.transfer import transfer
    from truepose.storage.engine.address import display_address
    from truepose.storage.errors import DatabaseInUseError

    read, written = _address(source), _address(target)
    try:
        with progress_bar() as told:
            head, drafts = transfer(read, written, told)
    except DatabaseInUseError as error:
        remark([str(error)])
        return _SERVICE_FAILED
    if json:
        print_json({
            "source": display_address(read),
            "target": display_address(written),
            "records": head.links,
            "head": head.text,
            "drafts": drafts,
        })
    else:
        print_lines([
            f"{display_address(written)}: {head.links} records, verified, and {drafts} drafts. "
            f"Chain head {head.text}."
        ])
    return 0


def _address(named: str | None) -> str:
    """Return the URL of a database that somebody names by URL or file, or of the user's own."""
    if named is None:
        return _url(None)
    return named if "://" in named else f"sqlite:///{Path(named).resolve()}"


def _url(database: str | None) -> str:
    from truepose.settings import default_database_url

    return database or default_database_url()


def retention_command(
    database: Url = None,
    copies: Annotated[Path | None, typer.Option(help="Folder of 'truepose serve --backup-to'.")] = None,
    keep_copies: Annotated[int, typer.Option(min=1, help="Number of newest copies to keep.")] = 7,
    logs_days: Annotated[float, typer.Option(min=0, help="Time for which rotated logs are kept.")] = 90.0,
    drop: Annotated[
        bool, typer.Option("--drop", help="Remove the files; without this option, they are only listed.")
    ] = False,
    json: Json = False,
) -> int:
    """List files that can be removed beside the database: old logs, surplus copies, leftovers.

    Records are never removed: readings, commands, results, certificates, uploads. Live values are not stored.

    Example: truepose retention --copies backups --drop
    """
    from truepose.settings import default_database_url
    from truepose.storage.backup.schedule import Rules, surplus
    from truepose.storage.backup.schedule import drop as drop_surplus
    from truepose.storage.engine.address import database_file

    found = surplus(database_file(database or default_database_url()), Rules(logs_days, copies, keep_copies))
    if drop:
        drop_surplus(found)
    if json:
        files = [{"file": str(one.file), "bytes": one.size_bytes, "why": one.why} for one in found]
        print_json({"dropped": drop, "files": files, "bytes": sum(one.size_bytes for one in found)})
    else:
        word = "removed" if drop else "can be removed"
        print_lines([f"{one.file}: {word} ({one.why}, {one.size_bytes / 1e6:.1f} MB)" for one in found])
        print_lines([f"{len(found)} files {word}, {sum(one.size_bytes for one in found) / 1e6:.1f} MB."])
    return 0
