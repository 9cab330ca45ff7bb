"""The open database: one writer, many readers, commits that are on disk.

Every write runs on one thread over one connection, in a transaction of its own; `write` returns
after the commit, which `synchronous=FULL` puts on the disk. Readers see the last commit (WAL) and
cannot write. SQLite's calls block, so both sides live on threads, off the event loop.
"""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

from sqlalchemy import Connection, Engine, create_engine, event
from sqlalchemy.exc import DatabaseError, OperationalError
from sqlalchemy.pool import NullPool, QueuePool

from service.storage.address import database_file
from service.storage.errors import ForeignDatabaseError, StorageUnavailableError
from service.storage.lock import ServiceLock
from service.storage.schema import bring_up_to_date

T = TypeVar("T")
_READERS = 4  # as many queries at a time as a handful of browsers asks for
_BUSY_TIMEOUT_MS = 5000  # a checkpoint or an outside backup may hold the file this long


class Database:
    """An open database; nothing else in the process writes to its file."""

    def __init__(self, url: str) -> None:
        self.file = database_file(url)
        self._lock = ServiceLock(self.file)
        self._commit = asyncio.Event()
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="storage-writer")
        self._readers = ThreadPoolExecutor(_READERS, thread_name_prefix="storage-reader")
        try:
            self.schema = self._writer.submit(self._open).result()
        except BaseException:
            self._shut()
            raise

    def _open(self) -> str:
        self._write_engine = _engine(self.file, read_only=False)
        self._read_engine = _engine(self.file, read_only=True)
        try:
            self._connection = self._write_engine.connect()
        except DatabaseError as error:
            raise _translated(self.file, error) from error
        try:
            with self._connection.begin():
                return bring_up_to_date(self._connection, str(self.file))
        except BaseException:
            self._connection.close()
            raise

    async def write(self, work: Callable[[Connection], T]) -> T:
        """Run `work` in a transaction and return its result once that is committed."""
        committed = asyncio.get_running_loop().run_in_executor(self._writer, self._write, work)
        committed.add_done_callback(self._announce)
        # Shielded: a caller that is cancelled meanwhile does not take the announcement with it.
        return await asyncio.shield(committed)

    async def read(self, work: Callable[[Connection], T]) -> T:
        """Run `work` on the last committed state; it cannot write."""
        return await asyncio.get_running_loop().run_in_executor(self._readers, self._read, work)

    @property
    def next_commit(self) -> asyncio.Event:
        """What the next commit sets; take it before a query, so that no commit falls between."""
        return self._commit

    def wake(self) -> None:
        """Wake everybody who waits for a commit."""
        self._commit.set()
        self._commit = asyncio.Event()

    def _announce(self, write: "asyncio.Future[Any]") -> None:
        if not write.cancelled() and write.exception() is None:
            self.wake()

    def _write(self, work: Callable[[Connection], T]) -> T:
        try:
            with self._connection.begin():
                return work(self._connection)
        except OperationalError as error:
            raise _translated(self.file, error) from error

    def _read(self, work: Callable[[Connection], T]) -> T:
        try:
            with self._read_engine.begin() as connection:
                return work(connection)
        except OperationalError as error:
            raise _translated(self.file, error) from error

    def close(self) -> None:
        """Finish what was begun, close the file and let another service have it."""
        self._readers.submit(self._read_engine.dispose).result()
        self._writer.submit(self._connection.close).result()
        self._writer.submit(self._write_engine.dispose).result()
        self._shut()

    def _shut(self) -> None:
        self._readers.shutdown()
        self._writer.shutdown()
        self._lock.release()


def _engine(file: Path, *, read_only: bool) -> Engine:
    # The writer keeps one connection; check_same_thread is off because the pool closes from any thread.
    engine = create_engine(
        f"sqlite:///{file}",
        poolclass=QueuePool if read_only else NullPool,
        connect_args={"check_same_thread": False},
    )
    event.listen(engine, "connect", _set_up_reader if read_only else _set_up_writer)
    event.listen(engine, "begin", _begin_reading if read_only else _begin_writing)
    return engine


def _set_up_writer(connection: Any, _record: object) -> None:
    connection.isolation_level = None  # the driver must not begin transactions on its own
    for pragma in ("journal_mode=WAL", "synchronous=FULL", "foreign_keys=ON"):
        connection.execute(f"PRAGMA {pragma}")
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")


def _set_up_reader(connection: Any, record: object) -> None:
    connection.isolation_level = None
    connection.execute(f"PRAGMA busy_timeout={_BUSY_TIMEOUT_MS}")
    connection.execute("PRAGMA query_only=ON")


def _begin_writing(connection: Connection) -> None:
    # IMMEDIATE: the write lock is taken now, not in the middle of a transaction that has read already.
    connection.exec_driver_sql("BEGIN IMMEDIATE")


def _begin_reading(connection: Connection) -> None:
    connection.exec_driver_sql("BEGIN")


def _translated(file: Path, error: DatabaseError) -> StorageUnavailableError | ForeignDatabaseError:
    if "not a database" in str(error.orig):
        return ForeignDatabaseError(f"{file} is not a SQLite database; choose another file.")
    return StorageUnavailableError(
        f"The database {file} refused ({error.orig}); check the disk's space and permissions."
    )
