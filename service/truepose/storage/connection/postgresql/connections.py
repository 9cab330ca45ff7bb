"""Connections to a database of a server: one that writes and holds the lock, some that cannot write."""

import json
from typing import Any, Final

import psycopg
from sqlalchemy import URL, Connection, Engine, create_engine, event
from sqlalchemy.pool import NullPool, QueuePool

from truepose.storage.connection.address import parsed_url
from truepose.storage.connection.postgresql.plain import PlainConnection
from truepose.storage.documents import from_json

ACCEPTED: Final = "fsync"  # option of a URL: `fsync=off` accepts a server that runs so
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
_READ_ONLY: Final = (
    "SET default_transaction_read_only = on",
    "SET default_transaction_isolation = 'repeatable read'",
)


def writing_engine(url: URL) -> Engine:
    """Return the engine of the one connection that writes."""
    engine = _engine(url, NullPool)
    event.listen(engine, "connect", _set_up_writer)
    return engine


def reading_engine(url: URL, most: int) -> Engine:
    """Return an engine whose connections see the last commit and cannot write."""
    engine = _engine(url, QueuePool, pool_size=most)
    event.listen(engine, "connect", _set_up_reader)
    return engine


def opened(url: str) -> PlainConnection:
    """Return a connection that reads a database, one moment of it in each transaction."""
    parsed = parsed_url(url).difference_update_query([ACCEPTED])
    connection = psycopg.connect(parsed.render_as_string(hide_password=False), autocommit=True, **_OURS)  # type: ignore[arg-type]
    _set(connection, *_THEIRS, *_READ_ONLY)
    return PlainConnection(connection)


def _engine(url: URL, pool: Any, **options: Any) -> Engine:
    engine = create_engine(
        url.set(drivername="postgresql+psycopg").difference_update_query([ACCEPTED]),
        poolclass=pool,
        connect_args=_OURS,
        json_serializer=json.dumps,  # as SQLite's documents are written
        json_deserializer=from_json,
        **options,
    )
    event.listen(engine, "begin", _begin)
    return engine


def _set_up_writer(connection: Any, _record: object) -> None:
    _set(connection, *_THEIRS, _WRITING, _DURABLE)


def _set_up_reader(connection: Any, _record: object) -> None:
    _set(connection, *_THEIRS, *_READ_ONLY)


def _set(connection: "psycopg.Connection[Any]", *statements: str) -> None:
    connection.autocommit = True  # the library must not begin transactions on its own
    connection.execute("; ".join(statements).encode())


def _begin(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN")
