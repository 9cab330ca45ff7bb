"""The SQLite library, connections to the database file, and refusals in the storage's own errors.

SQLite 3.7.0 to 3.51.2 may corrupt a database in WAL mode where one connection resets the log while another
one makes a checkpoint (sqlite.org, "The WAL-reset bug"; mended in 3.51.3, 3.50.7 and 3.44.6). Python's own
module has whatever library the system ships, so a newer one is taken where it is installed. With an older
one the fault cannot strike either: in this process only the writer's thread writes and makes checkpoints,
and the lock keeps other services off.
"""

import importlib
import sqlite3
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Final
from urllib.parse import quote

from sqlalchemy import Connection, Dialect, Engine, create_engine, event
from sqlalchemy.exc import DatabaseError, IntegrityError
from sqlalchemy.pool import NullPool, QueuePool
from sqlalchemy.util import LRUCache

from truepose.storage.documents import from_json
from truepose.storage.errors import (
    ConflictError,
    ForeignDatabaseError,
    StorageError,
    StorageUnavailableError,
    damaged,
)

_MENDED: Final = (3, 51, 3)
_MENDED_LINES: Final = {(3, 50): 7, (3, 44): 6}  # older lines and their first patch with the mend
_FIRST_FAULTY: Final = (3, 7, 0)


def has_wal_reset_fault(version: tuple[int, int, int]) -> bool:
    """Whether a version of SQLite may corrupt a database when it resets the write-ahead log."""
    if version < _FIRST_FAULTY or version >= _MENDED:
        return False
    mended_from = _MENDED_LINES.get(version[:2])
    return mended_from is None or version[2] < mended_from


def _newest() -> ModuleType:
    """Return the module with the newer library: the one that is installed beside Python's, or Python's."""
    try:
        beside = importlib.import_module("pysqlite3.dbapi2")
    except ImportError:
        return sqlite3
    # Only a newer one: a system may ship a library that was mended after the wheel was made.
    return beside if beside.sqlite_version_info > sqlite3.sqlite_version_info else sqlite3


LIBRARY: Final = _newest()
VERSION: Final[str] = LIBRARY.sqlite_version
FAULTY: Final = has_wal_reset_fault(LIBRARY.sqlite_version_info)


# Statements, for writer and readers alike: compiling one takes longer than running it.
_COMPILED: Final = LRUCache[Any, Any](1000)
_BUSY_TIMEOUT_MS: Final = 5000  # a checkpoint or an outside backup may hold the file this long

_OF_WRITER: Final = (
    "journal_mode=WAL",
    # In WAL mode NORMAL would sync at checkpoints only, and a loss of power would take commits that were
    # acknowledged.
    "synchronous=FULL",
    # Off by default, and a property of each connection.
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
    # Read-only, so that whoever looks at a database from outside can neither change it nor take over its log.
    connection = LIBRARY.connect(f"file:{quote(str(file))}?mode=ro", uri=True, isolation_level=None)
    # As bytes: a text with a wrong bit need not be a text any more. Blobs are bytes, texts bytearrays.
    connection.text_factory = bytearray
    connection.execute("PRAGMA busy_timeout=5000")
    return connection


def _engine(file: Path, mode: str, pool: Any) -> Engine:
    def connect() -> Any:
        # check_same_thread is off because the pool closes from any thread.
        return LIBRARY.connect(f"file:{quote(str(file))}?mode={mode}", uri=True, check_same_thread=False)

    engine = create_engine(
        "sqlite://",
        module=LIBRARY,
        creator=connect,
        poolclass=pool,
        execution_options={"compiled_cache": _COMPILED},
    )
    engine.dialect = _dialect()
    return engine


@cache
def _dialect() -> Dialect:
    """Return what writes statements for the library, the same for every engine of the process.

    What was compiled serves an engine only where it was compiled for that very dialect.
    """
    # A dialect learns at its first connection what the library can do; that takes no file.
    engine = create_engine("sqlite://", module=LIBRARY, json_deserializer=from_json)
    with engine.connect():
        return engine.dialect


def _set_up_writer(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver must not begin transactions on its own
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")
    for pragma in _OF_WRITER:
        connection.execute(f"PRAGMA {pragma}")


def _set_up_reader(connection: Any, _record: object) -> None:
    connection.isolation_level = None
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")
    # Opened for writing all the same: a reader of a write-ahead log has to write into the log's index.
    connection.execute("PRAGMA query_only=ON")
    connection.execute("PRAGMA wal_autocheckpoint=0")  # the writer's business alone


def _begin_writing(connection: Connection) -> None:
    # IMMEDIATE: the write lock is taken now, not in the middle of a transaction that has read already.
    connection.exec_driver_sql("BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN")


REFUSED: Final = (DatabaseError, LIBRARY.DatabaseError)  # the chain asks the library without the toolkit
_FOREIGN: Final = "not a database"
_DAMAGE: Final = (
    _FOREIGN,
    "malformed",
    "corrupt",
    "no such table",
    "no such column",
    "disk image",
    "decode to UTF-8",
)


def refused_at_opening(file: Path, error: Exception) -> StorageError:
    """Return what `translate_error` does, of a file that may never have been a database."""
    if _FOREIGN in str(error):
        return ForeignDatabaseError(f"{file} is not a SQLite database; choose another file.")
    return translate_error(file, error)


def translate_error(file: Path, error: Exception) -> StorageError:
    """Return an error of the library, wrapped or as it is, as one of ours."""
    said = str(error.orig if isinstance(error, DatabaseError) else error)
    if isinstance(error, (IntegrityError, LIBRARY.IntegrityError)):
        return ConflictError(f"The records do not allow that ({said}); nothing was kept.")
    if any(word in said for word in _DAMAGE):
        return damaged(str(file), said)
    return StorageUnavailableError(
        f"The database {file} refused ({said}); check the disk's space and permissions."
    )


def says_full(error: Exception) -> bool:
    """Whether the library says that there is no room; the index of the log has words of its own for it."""
    said = str(error)
    return "is full" in said or "disk I/O error" in said
