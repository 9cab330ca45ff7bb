"""Connections to the database file: one that writes, some that cannot."""

from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.pool import NullPool, QueuePool

from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.documents import from_json

_BUSY_TIMEOUT_MS: Final = 5000  # a checkpoint or an outside backup may hold the file this long

_OF_WRITER: Final = (
    "journal_mode=WAL",
    "synchronous=FULL",
    "foreign_keys=ON",
    "recursive_triggers=ON",  # a row that REPLACE would delete meets the trigger that refuses it
    "secure_delete=ON",  # what is taken out is gone from the pages as well
)


def writing_engine(file: Path) -> Engine:
    """Return the engine of the one connection that writes; it makes the file where there is none."""
    engine = _engine(file, "rwc", NullPool)
    event.listen(engine, "connect", _set_up_writer)
    event.listen(engine, "begin", _begin_writing)
    return engine


def reading_engine(file: Path) -> Engine:
    """Return an engine whose connections see the last commit and cannot write."""
    # Never made anew: behind a file that was removed, readers must not find an empty database.
    engine = _engine(file, "rw", QueuePool)
    event.listen(engine, "connect", _set_up_reader)
    event.listen(engine, "begin", _begin_reading)
    return engine


def opened_file(file: Path) -> Any:
    """Return a connection that reads a database, texts as bytearrays."""
    connection = LIBRARY.connect(f"file:{quote(str(file))}?mode=ro", uri=True, isolation_level=None)
    # As bytes: a text with a wrong bit need not be a text any more. Blobs are bytes, texts bytearrays.
    connection.text_factory = bytearray
    connection.execute("PRAGMA busy_timeout=5000")
    return connection


def _engine(file: Path, mode: str, pool: Any) -> Engine:
    def connect() -> Any:
        # check_same_thread is off because the pool closes from any thread.
        return LIBRARY.connect(f"file:{quote(str(file))}?mode={mode}", uri=True, check_same_thread=False)

    return create_engine(
        "sqlite://", module=LIBRARY, creator=connect, poolclass=pool, json_deserializer=from_json
    )


def _set_up_writer(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver must not begin transactions on its own
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")
    for pragma in _OF_WRITER:
        connection.execute(f"PRAGMA {pragma}")


def _set_up_reader(connection: Any, _record: object) -> None:
    connection.isolation_level = None
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")
    connection.execute("PRAGMA query_only=ON")
    connection.execute("PRAGMA wal_autocheckpoint=0")  # the writer's business alone


def _begin_writing(connection: Connection) -> None:
    # IMMEDIATE: the write lock is taken now, not in the middle of a transaction that has read already.
    connection.exec_driver_sql("BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN")
