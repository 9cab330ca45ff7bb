"""The place of an open database: still its own file, or removed, or another's by now.

A file that is removed lives on as long as somebody has it open, and everything that was acknowledged is in
it. So it is written anew at its place, which loses nothing; where something else lies there by now, that is
left alone and nothing is written until it is gone. A write-ahead log that is removed takes with it whatever
is in no other file; so everything is brought into the database and a new log is begun.
"""

import contextlib
import os
from pathlib import Path
from typing import Any

from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.connection.sqlite.lock import locked_file
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.files.owner_alone import make_alone

Identity = tuple[int, int]  # device and number of the file on it


class Place:
    """Where the database lies; asked by the writer's thread before each transaction."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._log = file.with_name(f"{file.name}-wal")
        self._is = _identity(file)
        self._log_is = _identity(self._log)

    @property
    def removed(self) -> bool:
        """Whether nothing lies there any more; raises StorageUnavailableError where something else does."""
        found = _identity(self._file)
        if found is not None and found != self._is:
            raise StorageUnavailableError(
                f"Another file lies at {self._file} in place of the open database; put it elsewhere, "
                "then the service writes its own there again."
            )
        return found is None

    @property
    def lies_alone(self) -> bool:
        """Whether the file is at its place and everything is in it."""
        return _identity(self._file) == self._is and _identity(self._log) is None

    @property
    def log_removed(self) -> bool:
        """Whether the write-ahead log is gone from its place."""
        found = _identity(self._log)
        if self._log_is is None:
            self._log_is = found
        return found != self._log_is

    def restore(self, connection: Any) -> int | None:
        """Write the database anew from a connection that has it open; returns the lock on the new file.

        Raises StorageUnavailableError where that is not possible; then nothing lies there.
        """
        copy = self._file.with_name(f"{self._file.name}.rescued")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            copy.unlink(missing_ok=True)
            _copy(connection, copy)
            lock = locked_file(copy)
            for leftover in (self._log, self._file.with_name(f"{self._file.name}-shm")):
                leftover.unlink(missing_ok=True)  # of the file that was removed: not of this one
            copy.rename(self._file)
            sync_folder(self._file.parent)
        except (OSError, LIBRARY.DatabaseError) as error:
            raise StorageUnavailableError(
                f"The database {self._file} was removed and cannot be written anew ({error}); "
                "nothing is lost while the service runs. Make room for it at its place."
            ) from error
        return lock


def _identity(file: Path) -> Identity | None:
    with contextlib.suppress(OSError):
        found = os.stat(file)
        return found.st_dev, found.st_ino
    return None


def _copy(connection: Any, target: Path) -> None:
    make_alone(target)
    copy = LIBRARY.connect(target)
    try:
        connection.backup(copy)
    finally:
        copy.close()
    with target.open("rb+") as written:
        os.fsync(written.fileno())


def sync_folder(folder: Path) -> None:
    """See that a name that was just given or taken in a folder is on the disk."""
    if os.name == "posix":
        opened = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
