"""The lock that keeps a second service off a database.

SQLite itself would let two services write in turns, and each would move its own robot. The lock is
an exclusive transaction on a side file: the operating system releases it with the process, however
that ends, so a killed service leaves nothing to clean up; and it works wherever SQLite does.
"""

import sqlite3
from pathlib import Path

from service.storage.errors import DatabaseInUseError, StorageUnavailableError


class ServiceLock:
    """Held from construction to `release`; raises DatabaseInUseError when somebody else holds it."""

    def __init__(self, database: Path) -> None:
        self._connection = _connect(database)
        try:
            self._connection.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            self._connection.close()
            raise _refusal(database, error) from error

    def release(self) -> None:
        """Let another service have the database."""
        self._connection.close()


def _connect(database: Path) -> sqlite3.Connection:
    try:
        database.parent.mkdir(parents=True, exist_ok=True)
        # check_same_thread off: opened by whoever starts the service, released by whoever stops it.
        return sqlite3.connect(f"{database}.lock", timeout=0.0, check_same_thread=False, isolation_level=None)
    except (OSError, sqlite3.OperationalError) as error:
        raise _refusal(database, error) from error


def _refusal(database: Path, error: Exception) -> DatabaseInUseError | StorageUnavailableError:
    if "locked" in str(error):
        return DatabaseInUseError(
            f"The database {database} is in use by another truepose service; "
            "stop that one, or choose another file with --database."
        )
    return StorageUnavailableError(
        f"The database {database} cannot be written ({error}); check the folder and its permissions."
    )
