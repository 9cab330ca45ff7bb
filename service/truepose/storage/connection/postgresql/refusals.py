"""What a server refuses, in the storage's own errors: nothing else leaves this room."""

from collections.abc import Mapping
from typing import Final

import psycopg
from sqlalchemy.exc import DBAPIError

from truepose.storage.connection.postgresql.identity import read_only
from truepose.storage.errors import (
    ConflictError,
    ServerAwayError,
    ServerRefusedError,
    StorageError,
    damaged,
)

REFUSED: Final = (DBAPIError, psycopg.Error)  # the chain asks the library without the toolkit
_NOT_ALLOWED: Final = ("22", "23")  # classes of codes: data that no column takes, constraints
_DAMAGE: Final = ("XX001", "XX002", "42P01", "42703")  # pages, indices, tables and columns that are gone
_ENDED: Final = ("08", "57P", "25P03")
_READ_ONLY: Final = "25006"

_ROOM: Final = "make room on the disk of the server, or mend it."
_CONNECTIONS: Final = "end what else is connected there, or raise max_connections."
_RIGHTS: Final = "make the database's user the owner of its schema and tables."
_CHECK: Final = "check the server and the rights of the database's user."
_TO_DO: Final[Mapping[str, str]] = {  # by how codes begin
    "53100": _ROOM,
    "53200": "the server has no memory left: see what else it does.",
    "533": _CONNECTIONS,
    "58": _ROOM,
    "42501": _RIGHTS,
    "55P03": "somebody has locked a table: see who.",
    "57014": "somebody ended the statement: see who.",
}
# Who is not let in is told a sentence and no code, in the server's own language: of others, see _LET_IN.
_LET_IN: Final = "see that it runs, and that it lets this service in."
_NOT_LET_IN: Final[Mapping[str, str]] = {
    "too many clients": _CONNECTIONS,
    "too many connections": _CONNECTIONS,
    "connection slots": _CONNECTIONS,
    "password": "check user and password (PGPASSWORD or ~/.pgpass).",
    "pg_hba.conf": "let this computer and user in there (pg_hba.conf), with TLS where that is asked for.",
    "does not support SSL": "set ssl = on there, or ask for none (sslmode).",
    "certificate": "check the certificate of the server, and sslrootcert.",
    '" does not exist': "make it there, or name another with --database.",
}


def translated(where: str, error: Exception) -> StorageError:
    """Return an error of the library, wrapped or as it is, as one of ours."""
    original = _original(error)
    code, said = _code(original), " ".join(str(original).split())
    if code.startswith(_NOT_ALLOWED) or isinstance(original, psycopg.DataError):
        return ConflictError(f"The records do not allow that ({said}); nothing was kept.")
    if code in _DAMAGE:
        return damaged(where, said)
    if has_ended(error):
        return _not_reached(where, said)
    if code == _READ_ONLY:
        return ServerRefusedError(read_only(where, said))
    return ServerRefusedError(f"The database {where} refused ({said}); {_to_do(code)}")


def has_ended(error: Exception) -> bool:
    """Whether a connection has ended, or could not be begun."""
    original = _original(error)
    if isinstance(original, psycopg.InterfaceError):  # it was closed already
        return True
    return isinstance(original, psycopg.OperationalError) and (
        original.sqlstate is None or original.sqlstate.startswith(_ENDED)
    )


def _not_reached(where: str, said: str) -> StorageError:
    to_do = next((to_do for words, to_do in _NOT_LET_IN.items() if words in said), None)
    if to_do is None:
        return ServerAwayError(f"The server of {where} does not answer ({said}); {_LET_IN}")
    return ServerRefusedError(f"The server of {where} lets nobody in ({said}); {to_do}")


def _to_do(code: str) -> str:
    return next((to_do for begin, to_do in _TO_DO.items() if code.startswith(begin)), _CHECK)


def _original(error: Exception) -> BaseException:
    return error.orig if isinstance(error, DBAPIError) and error.orig is not None else error


def _code(error: BaseException) -> str:
    return (error.sqlstate or "") if isinstance(error, psycopg.Error) else ""
