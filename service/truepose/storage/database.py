"""The open database: one writer, many readers, commits that are on disk.

Every write runs on one thread over one connection; what is asked for while a commit is under way shares the
next transaction, each in a savepoint of its own. `write` returns once the commit is on the disk. Readers see
the last commit and cannot write. The library's calls block, so both sides live on threads, off the event
loop. Where a write is refused, further ones are refused at once until a trial has shown that writing works
again. What differs from engine to engine is behind `connection.holding`.
"""

import asyncio
import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias, TypeVar

from sqlalchemy import Connection

from truepose.storage.connection.commits import Commits
from truepose.storage.connection.engines import holding
from truepose.storage.connection.holding import READERS, InDoubtError
from truepose.storage.connection.plain import plain
from truepose.storage.errors import DamagedDatabaseError, StorageError, StorageUnavailableError, damaged
from truepose.storage.integrity.condition import Condition
from truepose.storage.integrity.head import Head, newest_head
from truepose.storage.integrity.linking import linking
from truepose.storage.integrity.seal import Left
from truepose.storage.integrity.verification import stream_findings

T = TypeVar("T")
_End: TypeAlias = tuple[Any, Exception | None]  # what a write gave, or why it failed
_LOG: Final = logging.getLogger(__name__)
_MOST_TOGETHER: Final = 256  # writes that share a transaction
_IN_DOUBT: Final = "The connection to {} ended during a commit; whether that was made shows once it is back."
_TRIAL_S: Final = 0.25  # between two trials whether writing works again


@dataclass(frozen=True, slots=True)
class _Wanted:
    """A write that waits for its turn."""

    work: Callable[[Connection], Any]
    loop: asyncio.AbstractEventLoop  # of whoever waits
    done: "Future[Any]" = field(default_factory=Future)


class Database:
    """An open database; nothing else in the process writes to it."""

    def __init__(self, url: str) -> None:
        self.condition = Condition()
        self.commits = Commits()
        self._commit = asyncio.Event()
        self._wanted: deque[_Wanted] = deque()
        self._doubtful: _Doubtful | None = None
        self._trial: asyncio.Task[None] | None = None
        self._reading = threading.BoundedSemaphore(READERS)  # all of them taken: nobody reads
        self.held = holding(url, self.condition, self._nobody_reads)
        self.file = self.held.file  # what lies beside the database is named after it
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="storage-writer")
        self._readers = ThreadPoolExecutor(READERS, thread_name_prefix="storage-reader")
        try:
            self.schema = self._writer.submit(self.held.open).result()
        except BaseException:
            self._shut()
            raise

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
        await self.write(self.held.write_a_little)

    async def write_new(self, work: Callable[[Connection], T]) -> T:
        """Write what begins something new; refused like a full disk where only the reserve is left."""
        if self.condition.low is not None:
            raise StorageUnavailableError(self.condition.low)
        return await self.write(work)

    async def keep_reserve(self) -> None:
        """Take room for a full disk where there is some, and take it back once there is some again."""
        await self.on_writer(lambda _plain: self.held.keep_reserve())

    async def writable(self) -> None:
        """Return once writing works; at once where nothing was refused."""
        while self._trial is not None:
            await asyncio.wait({self._trial})

    async def read(self, work: Callable[[Connection], T]) -> T:
        """Run `work` on the last committed state; it cannot write."""
        return await asyncio.get_running_loop().run_in_executor(self._readers, self._read, work)

    async def on_writer(self, work: Callable[[Any], T]) -> T:
        """Run `work` with the library's writing connection, outside transactions, the database ready for it.

        Raises StorageUnavailableError.
        """

        def looked_after() -> T:
            try:
                self._make_ready()
                return work(self.held.plain)
            except self.held.refused as error:
                raise self._noted(error) from error

        try:
            return await asyncio.get_running_loop().run_in_executor(self._writer, looked_after)
        except StorageUnavailableError as error:
            self._try_again_after(error)
            raise

    async def require_intact(self, session_id: int) -> None:
        """Raise DamagedDatabaseError where a record of a session is not as it was written."""

        def findings(connection: Connection) -> list[str]:
            return [*stream_findings(plain(connection), session_id)]

        found = await self.read(findings)
        for finding in found:
            self.condition.note_damage(finding, finding)
        if found:
            raise damaged(self.held.where, found[0])

    async def head(self) -> Head:
        """Return the head of the chain, which reports print; 'truepose verify --head' takes it."""
        return await self.read(lambda connection: newest_head(plain(connection)))

    @property
    def next_commit(self) -> asyncio.Event:
        """What the next commit sets; take it before a query, so that no commit falls between."""
        return self._commit

    def wake(self) -> None:
        """Wake everybody who waits for a commit."""
        self._commit.set()
        self._commit = asyncio.Event()

    async def _write_in_turn(self, work: Callable[[Connection], T]) -> T:
        wanted = _Wanted(work, asyncio.get_running_loop())
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
                    await self._write_in_turn(self.held.write_a_little)
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
            self._write_alone(together[0])
            return
        try:
            refused = self.held.refused
            _tell(together, self._write(lambda c: [_beside(wanted, c, refused) for wanted in together]))
        except _NotTogetherError:
            for wanted in together:
                self._write_alone(wanted)
        except _DoubtError as doubt:
            self._wait_for_certainty(_Doubtful(together, doubt.result, doubt.newest))
        except Exception as error:
            _tell(together, [(None, error) for _ in together])

    def _write_alone(self, wanted: _Wanted) -> None:
        try:
            _tell([wanted], [(self._write(wanted.work), None)])
        except _DoubtError as doubt:
            self._wait_for_certainty(_Doubtful([wanted], [(doubt.result, None)], doubt.newest))
        except Exception as error:
            _tell([wanted], [(None, error)])

    def _write(self, work: Callable[[Connection], T]) -> T:
        try:
            return self._committed(work)
        except self.held.refused as error:
            if self.held.make_room(error):
                return self._write(work)  # in the room that is free now
            raise self._noted(error) from error

    def _committed(self, work: Callable[[Connection], T]) -> T:
        self._make_ready()
        begun_s = time.perf_counter()
        connection = self.held.connection
        transaction, links = connection.begin(), linking(connection)
        try:
            result = work(connection)
            self.held.commit(transaction, links.write(plain(connection)))
        except InDoubtError as doubt:
            raise _DoubtError(result, doubt.newest) from doubt
        except BaseException:
            links.forget()
            transaction.rollback()
            raise
        self.commits.note(time.perf_counter() - begun_s)
        return result

    def _make_ready(self) -> None:
        self.held.make_ready()
        if self._doubtful is not None:
            self._tell_certainty(self._doubtful, self.held.has(self._doubtful.newest))

    def _wait_for_certainty(self, doubtful: "_Doubtful") -> None:
        """Answer nobody of a commit that may have been made, and refuse others until that is known."""
        self._doubtful = doubtful
        error = StorageUnavailableError(_IN_DOUBT.format(self.held.where))
        self.condition.trouble = str(error)
        doubtful.together[0].loop.call_soon_threadsafe(self._try_again_after, error)

    def _tell_certainty(self, doubtful: "_Doubtful", made: bool) -> None:
        self._doubtful = None
        refused = StorageUnavailableError(f"The connection to {self.held.where} ended; nothing was kept.")
        _LOG.warning("the commit during which the connection ended was %s", "made" if made else "not made")
        _tell(doubtful.together, doubtful.ends if made else [(None, refused) for _ in doubtful.ends])

    def _leave(self) -> None:
        """Leave the database as it should be left; what is still in doubt stays so."""
        if self._doubtful is not None:
            unknown = StorageUnavailableError(_IN_DOUBT.format(self.held.where))
            _tell(self._doubtful.together, [(None, unknown) for _ in self._doubtful.ends])
        self.held.close()

    @contextlib.contextmanager
    def _nobody_reads(self) -> Iterator[None]:
        for _ in range(READERS):
            self._reading.acquire()
        try:
            yield
        finally:
            for _ in range(READERS):
                self._reading.release()

    # on any thread

    def _read(self, work: Callable[[Connection], T], *, again: bool = True) -> T:
        try:
            with self._reading, self.held.readers.begin() as connection:
                return work(connection)
        except self.held.refused as error:
            if again and self.held.ended(error):  # while it lay idle, perhaps; another one may do
                return self._read(work, again=False)
            raise self._noted(error) from error

    def _noted(self, error: Exception) -> StorageError:
        found = self.held.translated(error)
        if isinstance(found, DamagedDatabaseError):
            self.condition.note_damage("pages", str(found))
        return found

    def close(self) -> None:
        """Finish what was begun, close the database and let another service have it."""
        if self._trial is not None:
            self._trial.cancel()
        self._readers.shutdown()
        self._writer.submit(self._leave).result()
        self._shut()

    def _shut(self) -> None:
        self._readers.shutdown()
        self._writer.shutdown()


@dataclass(frozen=True, slots=True)
class _Doubtful:
    """Writes of a commit that may have been made."""

    together: Sequence[_Wanted]
    ends: Sequence[_End]  # if it was
    newest: Left  # link that the database has if it was


class _DoubtError(Exception):
    """Whether a commit was made is not known yet."""

    def __init__(self, result: Any, newest: Left) -> None:
        super().__init__()
        self.result, self.newest = result, newest


class _NotTogetherError(Exception):
    """One of several writes has spoilt the transaction that they share."""


def _beside(wanted: _Wanted, connection: Connection, refused: tuple[type[Exception], ...]) -> _End:
    """Return what a write gives that shares its transaction; what it did is undone where it fails."""
    links = linking(connection)
    before = links.waiting
    try:
        with connection.begin_nested():
            return wanted.work(connection), None
    except refused as error:
        # The library may have ended the whole transaction by itself; alone, each has its own answer.
        raise _NotTogetherError from error
    except Exception as error:
        links.back_to(before)
        return None, error


def _tell(together: Sequence[_Wanted], ends: Sequence[_End]) -> None:
    for wanted, (result, failure) in zip(together, ends, strict=True):
        if failure is None:
            wanted.done.set_result(result)
        else:
            wanted.done.set_exception(failure)
