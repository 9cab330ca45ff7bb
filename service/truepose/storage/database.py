"""The open database: one writer, many readers, commits that are on disk.

Every write runs on one thread over one connection; what is asked for while a commit is under way shares the
next transaction, each in a savepoint of its own. `write` returns after the commit, which `synchronous=FULL`
puts on the disk. Readers see the last commit (WAL) and cannot write. SQLite's calls block, so both sides live
on threads, off the event loop. Where a write is refused, further ones are refused at once until a trial has
shown that writing works again.
"""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias, TypeVar

from sqlalchemy import Connection
from sqlalchemy.exc import DatabaseError

from truepose.storage.connection.address import database_file
from truepose.storage.connection.commits import Commits
from truepose.storage.connection.engine import reading_engine, writing_engine
from truepose.storage.connection.library import LIBRARY
from truepose.storage.connection.lock import ServiceLock
from truepose.storage.connection.place import Place
from truepose.storage.connection.refusals import REFUSED, damaged, says_full, translated
from truepose.storage.connection.reserve import Reserve
from truepose.storage.connection.schema import bring_up_to_date
from truepose.storage.errors import DamagedDatabaseError, StorageError, StorageUnavailableError
from truepose.storage.integrity.arrival import note_how_it_was_left
from truepose.storage.integrity.condition import RESERVE_IN_USE, Condition
from truepose.storage.integrity.head import Head, newest_head
from truepose.storage.integrity.seal import Seal
from truepose.storage.integrity.verification import stream_findings

T = TypeVar("T")
_End: TypeAlias = tuple[Any, Exception | None]  # what a write gave, or why it failed
_LOG: Final = logging.getLogger(__name__)
_READERS: Final = 4  # as many queries at a time as a handful of browsers asks for
_MOST_TOGETHER: Final = 256  # writes that share a transaction
_TRIAL_S: Final = 0.25  # between two trials whether writing works again


@dataclass(frozen=True, slots=True)
class _Wanted:
    """A write that waits for its turn."""

    work: Callable[[Connection], Any]
    done: "Future[Any]" = field(default_factory=Future)


class Database:
    """An open database; nothing else in the process writes to its file."""

    def __init__(self, url: str) -> None:
        self.file = database_file(url)
        self.condition = Condition()
        self.commits = Commits()
        self.reserve = Reserve(self.file)
        self._lock = ServiceLock(self.file)
        self._seal = Seal(self.file)
        self.left = self._seal.left()  # how the service before left the file; None where it did not say
        self._commit = asyncio.Event()
        self._wanted: deque[_Wanted] = deque()
        self._trial: asyncio.Task[None] | None = None
        self._reading = threading.BoundedSemaphore(_READERS)  # all of them taken: nobody reads
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="storage-writer")
        self._readers = ThreadPoolExecutor(_READERS, thread_name_prefix="storage-reader")
        try:
            self.schema = self._writer.submit(self._open).result()
        except BaseException:
            self._shut()
            raise

    def _open(self) -> str:
        log = self.file.with_name(f"{self.file.name}-wal")
        log_bytes = log.stat().st_size if log.exists() else 0
        self._connect()
        try:
            if self.left is not None and self.left.sha256 is not None:  # until the file was compared with it
                self._raw.execute("PRAGMA wal_autocheckpoint=0")
            with self._connection.begin():
                schema = bring_up_to_date(self._connection, str(self.file))
            note_how_it_was_left(self._raw, self.file, self.left, log_bytes, self.condition)
            self._seal.break_open(self._raw)
        except REFUSED as error:
            self._connection.close()
            raise translated(self.file, error) from error
        except BaseException:
            self._connection.close()
            raise
        self.place = Place(self.file)
        return schema

    def _connect(self) -> None:
        self._write_engine = writing_engine(self.file)
        self._read_engine = reading_engine(self.file)
        try:
            self._connection = self._write_engine.connect()
        except DatabaseError as error:
            raise translated(self.file, error) from error

    async def write(self, work: Callable[[Connection], T]) -> T:
        """Run `work` in a transaction and return its result once that is committed.

        Raises what `work` raises, and StorageUnavailableError; nothing of it was kept then.
        """
        if self.condition.trouble is not None:
            raise StorageUnavailableError(self.condition.trouble)
        try:
            return await self._write_in_turn(work)
        except StorageUnavailableError as error:
            self._try_again_after(error)
            raise

    async def write_a_trial(self) -> None:
        """Write a few bytes that nobody reads, to see that it works; raises StorageUnavailableError."""
        await self.write(_write_a_little)

    async def write_new(self, work: Callable[[Connection], T]) -> T:
        """Write what begins something new; refused like a full disk where only the reserve is left."""
        if self.condition.low is not None:
            raise StorageUnavailableError(self.condition.low)
        return await self.write(work)

    async def keep_reserve(self) -> None:
        """Take room for a full disk where there is some, and take it back once there is some again."""

        def keep(_connection: Any) -> None:
            self.reserve.take()
            if not self.reserve.used:
                self.condition.low = None

        await self.on_writer(keep)

    async def writable(self) -> None:
        """Return once writing works; at once where nothing was refused."""
        while self._trial is not None:
            await asyncio.wait({self._trial})

    async def read(self, work: Callable[[Connection], T]) -> T:
        """Run `work` on the last committed state; it cannot write."""
        return await asyncio.get_running_loop().run_in_executor(self._readers, self._read, work)

    async def on_writer(self, work: Callable[[Any], T]) -> T:
        """Run `work` with the library's writing connection, outside transactions, the file at its place.

        Raises StorageUnavailableError.
        """

        def looked_after() -> T:
            try:
                self._look_after_file()
                return work(self._raw)
            except LIBRARY.DatabaseError as error:
                raise self._noted(error) from error

        try:
            return await asyncio.get_running_loop().run_in_executor(self._writer, looked_after)
        except StorageUnavailableError as error:
            self._try_again_after(error)
            raise

    async def require_intact(self, session_id: int) -> None:
        """Raise DamagedDatabaseError where a record of a session is not as it was written."""

        def findings(connection: Connection) -> list[str]:
            return [*stream_findings(connection.connection.dbapi_connection, session_id)]

        found = await self.read(findings)
        for finding in found:
            self.condition.note_damage(finding, finding)
        if found:
            raise damaged(self.file, found[0])

    async def head(self) -> Head:
        """Return the head of the chain, which reports print; 'truepose verify --head' takes it."""
        return await self.read(lambda connection: newest_head(connection.connection.dbapi_connection))

    @property
    def next_commit(self) -> asyncio.Event:
        """What the next commit sets; take it before a query, so that no commit falls between."""
        return self._commit

    def wake(self) -> None:
        """Wake everybody who waits for a commit."""
        self._commit.set()
        self._commit = asyncio.Event()

    async def _write_in_turn(self, work: Callable[[Connection], T]) -> T:
        wanted = _Wanted(work)
        self._wanted.append(wanted)
        self._writer.submit(self._write_wanted)
        committed: asyncio.Future[T] = asyncio.wrap_future(wanted.done)
        committed.add_done_callback(self._announce)
        # Shielded: a caller that is cancelled meanwhile does not take the announcement with it.
        return await asyncio.shield(committed)

    def _announce(self, write: "asyncio.Future[Any]") -> None:
        if not write.cancelled() and write.exception() is None:
            self.wake()

    def _try_again_after(self, error: StorageUnavailableError) -> None:
        self.condition.trouble = str(error)
        if self._trial is None:
            _LOG.warning("records are refused: %s", error)
            self._trial = asyncio.create_task(self._try_until_writable(), name="storage trial")

    async def _try_until_writable(self) -> None:
        try:
            while self.condition.trouble is not None:
                await asyncio.sleep(_TRIAL_S)
                try:
                    await self._write_in_turn(_write_a_little)
                except StorageUnavailableError as error:
                    self.condition.trouble = str(error)
                else:
                    self.condition.trouble = None
                    _LOG.warning("records are taken again")
        finally:
            self._trial = None

    # on the writer's thread

    def _write_wanted(self) -> None:
        """Run what waits in one transaction; who came later shares the next one."""
        together = [self._wanted.popleft() for _ in range(min(len(self._wanted), _MOST_TOGETHER))]
        if not together:
            return
        if len(together) == 1:
            _tell(together, self._alone(together[0]))
            return
        try:
            _tell(together, *self._write(lambda connection: [_beside(w, connection) for w in together]))
        except _NotTogetherError:
            for wanted in together:
                _tell([wanted], self._alone(wanted))
        except Exception as error:
            _tell(together, *((None, error) for _ in together))

    def _alone(self, wanted: _Wanted) -> _End:
        try:
            return self._write(wanted.work), None
        except Exception as error:
            return None, error

    def _write(self, work: Callable[[Connection], T]) -> T:
        try:
            return self._committed(work)
        except REFUSED as error:
            if says_full(error) and self.reserve.give_up():
                self.condition.low = RESERVE_IN_USE
                _LOG.error("%s", RESERVE_IN_USE)
                return self._write(work)  # in the room that is free now
            raise self._noted(error) from error

    def _committed(self, work: Callable[[Connection], T]) -> T:
        if self._connection.closed:  # it could not be opened anew when it had to be
            self._connect()
        self._look_after_file()
        begun_s = time.perf_counter()
        with self._connection.begin():
            result = work(self._connection)
        self.commits.note(time.perf_counter() - begun_s)
        self._seal.note_newest(self._raw)
        return result

    def _look_after_file(self) -> None:
        """See that the database lies at its place with its log, and bring it back where it was removed."""
        if self.place.removed:
            lock = self.place.restore(self._raw)
            self._reconnect()
            self._lock.move_to(lock)
            _LOG.warning("the database %s was removed while it was open; it was written anew", self.file)
        elif self.place.log_removed:
            self._raw.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._reconnect()
            _LOG.warning("the log of %s was removed while it was open; a new one was begun", self.file)

    def _leave_at_its_place(self) -> None:
        """Bring the file back where it was removed since the last look; with the connection it is gone."""
        try:
            self._look_after_file()
        except (StorageError, LIBRARY.DatabaseError) as error:
            _LOG.error("the database is not as it should be left: %s", error)

    @property
    def _raw(self) -> Any:
        """The library's own connection, for what is done outside transactions."""
        return self._connection.connection.dbapi_connection

    def _reconnect(self) -> None:
        """Open everything anew, while nobody reads."""
        for _ in range(_READERS):
            self._reading.acquire()
        try:
            self._read_engine.dispose()
            self._connection.close()
            self._write_engine.dispose()
            self.place = Place(self.file)
            self._connect()
        finally:
            for _ in range(_READERS):
                self._reading.release()

    # on any thread

    def _read(self, work: Callable[[Connection], T]) -> T:
        try:
            with self._reading, self._read_engine.begin() as connection:
                return work(connection)
        except REFUSED as error:
            raise self._noted(error) from error

    def _noted(self, error: Exception) -> StorageError:
        found = translated(self.file, error)
        if isinstance(found, DamagedDatabaseError):
            self.condition.note_damage("pages", str(found))
        return found

    def close(self) -> None:
        """Finish what was begun, close the file and let another service have it."""
        if self._trial is not None:
            self._trial.cancel()
        self._writer.submit(self._leave_at_its_place).result()
        self._readers.submit(self._read_engine.dispose).result()
        self._writer.submit(self._connection.close).result()
        self._writer.submit(self._write_engine.dispose).result()
        self.reserve.release()
        self._seal.close(whole=self.place.lies_alone and not self.condition.damaged)
        self._shut()

    def _shut(self) -> None:
        self._readers.shutdown()
        self._writer.shutdown()
        self._lock.release()


class _NotTogetherError(Exception):
    """One of several writes has spoilt the transaction that they share."""


def _beside(wanted: _Wanted, connection: Connection) -> _End:
    """Return what a write gives that shares its transaction; what it did is undone where it fails."""
    try:
        with connection.begin_nested():
            return wanted.work(connection), None
    except REFUSED as error:
        # The library may have ended the whole transaction by itself; alone, each has its own answer.
        raise _NotTogetherError from error
    except Exception as error:
        return None, error


def _tell(together: Sequence[_Wanted], *ends: _End) -> None:
    for wanted, (result, failure) in zip(together, ends, strict=True):
        if failure is None:
            wanted.done.set_result(result)
        else:
            wanted.done.set_exception(failure)


def _write_a_little(connection: Connection) -> None:
    """Write a few bytes that nobody reads: the header's field for the application's use."""
    count = int(connection.exec_driver_sql("PRAGMA user_version").scalar() or 0)
    connection.exec_driver_sql(f"PRAGMA user_version = {(count + 1) % 2**31}")
