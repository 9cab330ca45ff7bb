"""What SQLite refuses, in the storage's own errors: nothing else leaves this room."""

from pathlib import Path
from typing import Final

from sqlalchemy.exc import DatabaseError, IntegrityError

from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.errors import (
    ConflictError,
    ForeignDatabaseError,
    StorageError,
    StorageUnavailableError,
    damaged,
)

REFUSED: Final = (DatabaseError, LIBRARY.DatabaseError)  # the chain asks the library without the toolkit
_DAMAGE: Final = ("malformed", "corrupt", "no such table", "no such column", "disk image", "decode to UTF-8")


def translated(file: Path, error: Exception) -> StorageError:
    """Return an error of the library, wrapped or as it is, as one of ours."""
    said = str(error.orig if isinstance(error, DatabaseError) else error)
    if isinstance(error, (IntegrityError, LIBRARY.IntegrityError)):
        return ConflictError(f"The records do not allow that ({said}); nothing was kept.")
    if "not a database" in said:
        return ForeignDatabaseError(f"{file} is not a SQLite database; choose another file.")
    if any(word in said for word in _DAMAGE):
        return damaged(str(file), said)
    return StorageUnavailableError(
        f"The database {file} refused ({said}); check the disk's space and permissions."
    )


def says_full(error: Exception) -> bool:
    """Whether the library says that there is no room; the index of the log has words of its own for it."""
    said = str(error)
    return "is full" in said or "disk I/O error" in said
