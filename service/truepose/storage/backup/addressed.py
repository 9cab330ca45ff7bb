"""Copies of a database by its address: always a file, of a server's database one with all its records."""

import os
from contextlib import closing
from pathlib import Path

from truepose.storage.backup.copying import Backup, Told, back_up, require_copy, written_copy
from truepose.storage.backup.restoring import restore, whole_copy
from truepose.storage.backup.transfer import fill, transfer
from truepose.storage.connection.address import database_file, is_server, parsed_url
from truepose.storage.connection.reading import lies_beside
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.errors import BackupError
from truepose.storage.integrity.head import Head


def back_up_at(
    url: str, target: Path, told: Told = lambda share, doing: None, *, replace: bool = False
) -> Backup:
    """Copy a database into one file, while a service runs or not; raises StorageError."""
    if not is_server(parsed_url(url)):
        return back_up(database_file(url), target, told, replace=replace)

    def write(part: Path, told: Told) -> Head:
        head = fill(url, f"sqlite:///{part}", told)
        _make_one_file(part)
        require_copy(part, head)
        return head

    return written_copy(lies_beside(url), target, write, told, replace=replace)


def restore_at(
    copy: Path, url: str, told: Told = lambda share, doing: None, *, replace: bool = False
) -> tuple[Head, Path | None]:
    """Put a copy in the place of a database; of a server's only into an empty one. Raises StorageError."""
    if not is_server(parsed_url(url)):
        return restore(copy, database_file(url), told, replace=replace)
    if replace:
        raise BackupError(
            "Nothing is put aside on a server: restore into an empty database of it and keep the one before."
        )
    whole_copy(copy, told)
    return transfer(f"sqlite:///{copy.resolve()}", url, told)[0], None


def _make_one_file(part: Path) -> None:
    """Leave a database that was just written as one file, which is on the disk."""
    with closing(LIBRARY.connect(part)) as copy:
        copy.execute("PRAGMA journal_mode=DELETE")
    with part.open("rb+") as written:
        os.fsync(written.fileno())
