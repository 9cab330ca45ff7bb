"""The lock that keeps a second service off a database.

SQLite itself would let two services write in turns, and each would move its own robot. Two locks are held
for life, and the operating system releases both with the process, however that ends:

- An exclusive transaction on a side file, wherever SQLite works.
- On Linux and Windows, a lock on the database file itself: whoever comes by another path, a hard link, a
  bind mount, from another container, or after the side file is gone, meets the same file. Closing any
  descriptor of the file would drop SQLite's own locks on Linux; so the one here is closed last.
"""

import os
from pathlib import Path
from typing import Any, Final

from truepose.storage.connection.sqlite.file_lock import file_lock
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.errors import DatabaseInUseError, StorageUnavailableError
from truepose.storage.files.owner_alone import make_alone, opened_alone, tighten

_BESIDE: Final = ("-wal", "-shm", "-journal", ".seal", ".reserve")  # of an older version, perhaps


class ServiceLock:
    """Held from construction to `release`; raises DatabaseInUseError when somebody else holds it."""

    def __init__(self, database: Path) -> None:
        self._file: int | None = None
        # The side file first: within one process, opening and closing the database would drop SQLite's locks.
        self._side = _locked_side_file(database)
        try:
            self._file = locked_file(database)
        except BaseException:
            self._side.close()
            raise

    def move_to(self, file: int | None) -> None:
        """Go over to a file that is locked already and takes the place of the one before."""
        before, self._file = self._file, file
        if before is not None:
            os.close(before)

    def release(self) -> None:
        """Let another service have the database."""
        self.move_to(None)
        self._side.close()


def locked_file(database: Path) -> int | None:
    """Return a descriptor of the database file that holds its lock; None where the system has no such lock.

    Raises DatabaseInUseError where another service holds it.
    """
    lock = file_lock()
    if lock is None:
        return None
    try:
        file = opened_alone(database, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise _unwritable(database, error) from error
    try:
        lock(file)
    except OSError as error:
        os.close(file)
        raise (
            _in_use(database) if isinstance(error, BlockingIOError) else _unwritable(database, error)
        ) from error
    return file


def _locked_side_file(database: Path) -> Any:
    try:
        database.parent.mkdir(parents=True, exist_ok=True)
        for part in ("", *_BESIDE):
            tighten(database.with_name(f"{database.name}{part}"))
        make_alone(Path(f"{database}.lock"))
        # check_same_thread off: opened by whoever starts the service, released by whoever stops it.
        side = LIBRARY.connect(f"{database}.lock", timeout=0.0, check_same_thread=False, isolation_level=None)
    except (OSError, LIBRARY.OperationalError) as error:
        raise _unwritable(database, error) from error
    try:
        side.execute("BEGIN EXCLUSIVE")
    except LIBRARY.DatabaseError as error:
        side.close()
        raise (_in_use(database) if "locked" in str(error) else _unwritable(database, error)) from error
    return side


def _in_use(database: Path) -> DatabaseInUseError:
    return DatabaseInUseError(
        f"The database {database} is in use by another truepose service; "
        "stop that one, or choose another file with --database."
    )


def _unwritable(database: Path, error: Exception) -> StorageUnavailableError:
    return StorageUnavailableError(
        f"The database {database} cannot be written ({error}); check the folder and its permissions."
    )
