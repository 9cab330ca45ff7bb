"""What a server refuses, in the storage's own errors: nothing else leaves this room."""

from typing import Final

import psycopg
from sqlalchemy.exc import DBAPIError

from truepose.storage.errors import ConflictError, StorageError, StorageUnavailableError, damaged

REFUSED: Final = (DBAPIError, psycopg.Error)  # the chain asks the library without the toolkit
_NOT_ALLOWED: Final = ("22", "23")  # classes of codes: data that no column takes, constraints
_DAMAGE: Final = ("XX001", "XX002", "42P01", "42703")  # pages, indices, tables and columns that are gone
_FULL: Final = ("53100", "53200")
_ENDED: Final = ("08", "57P")


def translated(where: str, error: Exception) -> StorageError:
    """Return an error of the library, wrapped or as it is, as one of ours."""
    original = _original(error)
    code, said = _code(original), " ".join(str(original).split())
    if code.startswith(_NOT_ALLOWED) or isinstance(original, psycopg.DataError):
        return ConflictError(f"The records do not allow that ({said}); nothing was kept.")
    if code in _DAMAGE:
        return damaged(where, said)
    if has_ended(error):
        return StorageUnavailableError(f"The server of {where} does not answer ({said}); see that it runs.")
    what = "the disk of the server" if code in _FULL else "the server and the rights of the database's user"
    return StorageUnavailableError(f"The database {where} refused ({said}); check {what}.")


def has_ended(error: Exception) -> bool:
    """Whether a connection has ended, or could not be begun."""
    original = _original(error)
    if isinstance(original, psycopg.InterfaceError):  # it was closed already
        return True
    return isinstance(original, psycopg.OperationalError) and (
        original.sqlstate is None or original.sqlstate.startswith(_ENDED)
    )


def _original(error: Exception) -> BaseException:
    return error.orig if isinstance(error, DBAPIError) and error.orig is not None else error


def _code(error: BaseException) -> str:
    return (error.sqlstate or "") if isinstance(error, psycopg.Error) else ""
