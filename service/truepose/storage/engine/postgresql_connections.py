"""Connections to a database of a server, and what the server refuses in the storage's own errors."""

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

import psycopg
from psycopg.adapt import AdaptersMap
from psycopg.types.string import TextLoader
from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.exc import DBAPIError
from sqlalchemy.pool import NullPool, QueuePool

from truepose.storage.documents import from_json
from truepose.storage.engine.address import parsed_url
from truepose.storage.engine.postgresql_server import read_only
from truepose.storage.errors import (
    ConflictError,
    ServerAwayError,
    ServerRefusedError,
    StorageError,
    damaged,
)

_AS_KEPT: Final = AdaptersMap(psycopg.adapters)
_AS_KEPT.register_loader("json", TextLoader)  # the text is in the hash, not what it means


class _KeptCursor(psycopg.Cursor[Any]):
    """Gives JSON as its text."""

    @property
    def adapters(self) -> AdaptersMap:
        return _AS_KEPT


class PlainConnection:
    """A connection of psycopg, asked like one of SQLite's library."""

    def __init__(self, server: "psycopg.Connection[Any]") -> None:
        self.server = server

    def execute(self, query: str, values: Sequence[Any] = ()) -> Any:
        """Run one statement and return what can be fetched; raises psycopg.Error."""
        # Statements of the chain hold neither question marks nor percent signs of their own.
        return _KeptCursor(self.server).execute(query.replace("?", "%s"), values)

    def executemany(self, query: str, rows: Iterable[Sequence[Any]]) -> None:
        """Run one statement for each of some rows; raises psycopg.Error."""
        _KeptCursor(self.server).executemany(query.replace("?", "%s"), rows)

    def copy_in(self, statement: str, rows: Iterable[Sequence[Any]]) -> None:
        """Send rows to a COPY statement; raises psycopg.Error."""
        with self.server.cursor().copy(statement.encode()) as copy:
            for row in rows:
                copy.write_row(row)

    def close(self) -> None:
        """End the connection."""
        self.server.close()


ACCEPTED: Final = "fsync"  # option of a URL: `fsync=off` accepts a server that runs so
# A trial is made again and again while the server is away; each holds the writer's thread for so long at
# most.
_CONNECT_S: Final = 5
# A server or a network that is gone without a word is noticed within some ten seconds, by either side.
_OURS: Final = {
    "client_encoding": "utf8",
    "connect_timeout": _CONNECT_S,
    "keepalives_idle": 5,
    "keepalives_interval": 2,
    "keepalives_count": 3,
    "tcp_user_timeout": 10_000,
    "application_name": "truepose",
}
# Whatever an administrator has set for others: a double comes with all its digits, a trigger is told as it
# was made, and no time limit ends a migration, a verification or the connection that holds the lock.
_THEIRS: Final = (
    "SET lock_timeout = '5s'",
    "SET tcp_keepalives_idle = 5",
    "SET tcp_keepalives_interval = 2",
    "SET tcp_keepalives_count = 3",
    "SET TIME ZONE 'UTC'",
    "SET extra_float_digits = 1",
    "SET quote_all_identifiers = off",
    "SELECT set_config(name, '0', false) FROM pg_settings WHERE name IN ('statement_timeout', "
    "'idle_in_transaction_session_timeout', 'idle_session_timeout', 'transaction_timeout')",
)
_WRITING: Final = "SET default_transaction_isolation = 'read committed'"  # nobody else writes
_DURABLE: Final = """
    SELECT set_config('synchronous_commit', 'on', false)
    WHERE current_setting('synchronous_commit') IN ('off', 'local')
"""
_READING: Final = (
    "SET default_transaction_read_only = on",
    "SET default_transaction_isolation = 'repeatable read'",
)


def writing_engine(url: URL) -> Engine:
    """Return the engine of the one connection that writes."""
    # No pool: a connection that came back from one would be another session of the server, without the lock.
    engine = _engine(url, NullPool)
    event.listen(engine, "connect", _set_up_writer)
    return engine


def reading_engine(url: URL, most: int) -> Engine:
    """Return an engine whose connections see the last commit and cannot write."""
    engine = _engine(url, QueuePool, pool_size=most)
    event.listen(engine, "connect", _set_up_reader)
    return engine


def open_connection(url: str) -> PlainConnection:
    """Return a connection that reads a database, one moment of it in each transaction."""
    parsed = parsed_url(url).difference_update_query([ACCEPTED])
    connection = psycopg.connect(parsed.render_as_string(hide_password=False), autocommit=True, **_OURS)  # type: ignore[arg-type]
    _set(connection, *_THEIRS, *_READING)
    return PlainConnection(connection)


def _engine(url: URL, pool: Any, **options: Any) -> Engine:
    engine = create_engine(
        url.set(drivername="postgresql+psycopg").difference_update_query([ACCEPTED]),
        poolclass=pool,
        connect_args=_OURS,
        # The text is in the hash: both engines have to write a document in the same letters.
        json_serializer=json.dumps,  # as SQLite's documents are written
        json_deserializer=from_json,
        **options,
    )
    event.listen(engine, "begin", _begin)
    return engine


def _set_up_writer(connection: Any, _record: object) -> None:
    _set(connection, *_THEIRS, _WRITING, _DURABLE)


def _set_up_reader(connection: Any, _record: object) -> None:
    _set(connection, *_THEIRS, *_READING)


def _set(connection: "psycopg.Connection[Any]", *statements: str) -> None:
    connection.autocommit = True  # the library must not begin transactions on its own
    connection.execute("; ".join(statements).encode())


def _begin(connection: Connection) -> None:
    # By hand, since the library's own transactions are off: see `_set`.
    connection.exec_driver_sql("BEGIN")


REFUSED: Final = (DBAPIError, psycopg.Error)  # the chain asks the library without the toolkit
_NOT_ALLOWED: Final = ("22", "23")  # classes of codes: data that no column takes, constraints
_DAMAGE: Final = ("XX001", "XX002", "42P01", "42703")  # pages, indices, tables and columns that are gone
_ENDED: Final = ("08", "57P", "25P03")
_NO_WRITES: Final = "25006"

_ROOM: Final = "free disk space on the server, or repair its disk."
_CONNECTIONS: Final = "close other connections to it, or raise max_connections."
_RIGHTS: Final = "make the database's user the owner of its schema and tables."
_CHECK: Final = "check the server and the rights of the database's user."
_TO_DO: Final[Mapping[str, str]] = {  # by how codes begin
    "53100": _ROOM,
    "53200": "the server is out of memory: check what else runs on it.",
    "533": _CONNECTIONS,
    "58": _ROOM,
    "42501": _RIGHTS,
    "55P03": "a table is locked: find out by whom.",
    "57014": "the statement was cancelled: find out by whom.",
}
# Who is not let in is told a sentence and no code, in the server's own language: of others, see _LET_IN.
_LET_IN: Final = "check that it is running and accepts this service."
_NOT_LET_IN: Final[Mapping[str, str]] = {
    "too many clients": _CONNECTIONS,
    "too many connections": _CONNECTIONS,
    "connection slots": _CONNECTIONS,
    "password": "check user and password (PGPASSWORD or ~/.pgpass).",
    "pg_hba.conf": "allow this computer and user in pg_hba.conf, with TLS if required.",
    "does not support SSL": "set ssl = on there, or turn TLS off with sslmode.",
    "certificate": "check the server's certificate, and sslrootcert.",
    '" does not exist': "create it there, or choose another with --database.",
}


def translate_error(where: str, error: Exception) -> StorageError:
    """Return an error of the library, wrapped or as it is, as one of ours."""
    original = _original(error)
    code, said = _code(original), " ".join(str(original).split())
    # The order matters: what the data do not allow is nobody's trouble but the caller's, and must not stop
    # the writes of others.
    if code.startswith(_NOT_ALLOWED) or isinstance(original, psycopg.DataError):
        return ConflictError(f"The records do not allow that ({said}); nothing was kept.")
    if code in _DAMAGE:
        return damaged(where, said)
    if has_ended(error):
        return _not_reached(where, said)
    if code == _NO_WRITES:
        return ServerRefusedError(read_only(where, said))
    return ServerRefusedError(f"The database {where} refused ({said}); {_to_do(code)}")


def has_ended(error: Exception) -> bool:
    """Whether a connection has ended, or could not be begun."""
    original = _original(error)
    if isinstance(original, psycopg.InterfaceError):  # it was closed already
        return True
    return isinstance(original, psycopg.OperationalError) and (
        # An error of the operation without a code comes from the library, not from the server: nobody
        # answered.
        original.sqlstate is None or original.sqlstate.startswith(_ENDED)
    )


def _not_reached(where: str, said: str) -> StorageError:
    to_do = next((to_do for words, to_do in _NOT_LET_IN.items() if words in said), None)
    if to_do is None:
        return ServerAwayError(f"The server of {where} does not respond ({said}); {_LET_IN}")
    return ServerRefusedError(f"The server of {where} refused the connection ({said}); {to_do}")


def _to_do(code: str) -> str:
    return next((to_do for begin, to_do in _TO_DO.items() if code.startswith(begin)), _CHECK)


def _original(error: Exception) -> BaseException:
    return error.orig if isinstance(error, DBAPIError) and error.orig is not None else error


def _code(error: BaseException) -> str:
    return (error.sqlstate or "") if isinstance(error, psycopg.Error) else ""
