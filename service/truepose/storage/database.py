"""The open database: one writer, many readers, commits that are on disk.

Every write runs on one thread over one connection; what is asked for while a commit is under way shares the
next transaction, and one of them that fails has a transaction of its own. `write` returns once the commit is
on the disk. Readers see the last commit and cannot write. The library's calls block, so both sides live on
threads, off the event loop. Where a write is refused, further ones are refused at once until a trial has
shown that writing works again. What differs from engine to engine is behind `engine.backend`.
"""

import asyncio
import contextlib
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Final, TypeVar

from sqlalchemy import Connection
from sqlalchemy.engine import Transaction

from truepose.storage.engine.address import is_server, parsed_url
from truepose.storage.engine.backend import READERS, Alone, Condition, DatabaseBackend, InDoubtError
from truepose.storage.engine.group_commit import (
    CommitTimes,
    GroupFailedError,
    GroupWrite,
    One,
    Outcome,
    PendingWrite,
    alone,
    run,
)
from truepose.storage.engine.raw_connection import plain
from truepose.storage.engine.reading import require_library
from truepose.storage.engine.sqlite import SQLiteFile
from truepose.storage.errors import (
    DamagedDatabaseError,
    ServerAwayError,
    StorageError,
    StorageUnavailableError,
    damaged,
)
from truepose.storage.integrity.database_identity import ClosingState
from truepose.storage.integrity.hash_chain import linking
from truepose.storage.integrity.head_hash import Head, newest_head
from truepose.storage.integrity.verification import stream_findings

T = TypeVar("T")
_LOG: Final = logging.getLogger(__name__)
# A group that fails is run anew, so its size is what one bad write may cost the others.
_MOST_TOGETHER: Final = 256  # writes that share a transaction
_IN_DOUBT: Final = (
    "The connection to {} was lost during a commit; whether the commit succeeded will not be known until the "
    "connection is restored."
)
_TRIAL_S: Final = 0.25  # between two trials whether writing works again


def backend_of(url: str, condition: Condition, alone: Alone) -> DatabaseBackend:
    """Return the database of a URL, not opened yet; raises DatabaseAddressError."""
    if not is_server(parsed_url(url)):
        return SQLiteFile(url, condition, alone)
    require_library()
    # Only here: the driver of PostgreSQL is an extra, and a cell with a file starts without it.
    from truepose.storage.engine.postgresql import ServerDatabase

    return ServerDatabase(url, condition, alone)


class Database:
    """An open database; nothing else in the process writes to it."""

    def __init__(self, url: str) -> None:
        self.condition = Condition()
        self.commits = CommitTimes()
        self._commit = asyncio.Event()
        self._wanted: deque[PendingWrite] = deque()
        self._handed_over = False  # what waits: the writer is going to look
        self._doubtful: _Doubtful | None = None
        self._trial: asyncio.Task[None] | None = None
        self._refused: type[StorageUnavailableError] = StorageUnavailableError  # while there is trouble
        # Not the pool's own limit: the writer has to be able to take every place before it closes the file
        # under the readers' connections.
        self._reading = threading.BoundedSemaphore(READERS)  # all of them taken: nobody reads
        self.backend = backend_of(url, self.condition, self._nobody_reads)
        # One thread for all that writes. That gives the order of commits, keeps the library's connection on
        # its thread, and is why the fault of the WAL reset cannot strike (`sqlite_connections`).
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="storage-writer")
        self._readers = ThreadPoolExecutor(READERS, thread_name_prefix="storage-reader")
        try:
            self.schema = self._writer.submit(self.backend.open).result()
        except BaseException:
            self._shut()
            raise
        self.file = self.backend.file  # what lies beside the database is named after it

    async def write(self, work: Callable[[Connection], T]) -> T:
        """Run `work` in a transaction and return its result once that is committed.

        It is run anew where another write that shares the transaction fails. Raises what `work` raises, and
        StorageUnavailableError; nothing of it was kept then.
        """
        result: T = await self.write_together(alone(work), None)
        return result

    async def write_together(self, work: GroupWrite[One], one: One) -> Any:
        """Keep `one` by `work`, which keeps all that are given to it meanwhile in one go.

        Returns or raises the end that `work` says for it, once that is committed: what it refuses it says
        there, and keeps nothing of. Raises StorageUnavailableError.
        """
        # Refused at once, without a try: while the disk refuses, each try may wait five seconds for a lock,
        # with everybody behind it.
        if self.condition.trouble is not None:
            raise self._refused(self.condition.trouble)
        try:
            return await self._write_in_turn(work, one)
        except StorageUnavailableError as error:
            self._try_again_after(error)
            raise

    async def write_a_trial(self) -> None:
        """Write a few bytes that nobody reads, to see that it works; raises StorageUnavailableError."""
        await self.write(self.backend.write_a_little)

    async def write_new(self, work: Callable[[Connection], T]) -> T:
        """Write what begins something new; refused like a full disk where only the reserve is left."""
        # A session under way goes on writing in the reserve; what would begin now could not be brought to its
        # end.
        if self.condition.low is not None:
            raise StorageUnavailableError(self.condition.low)
        return await self.write(work)

    async def keep_reserve(self) -> None:
        """Take room for a full disk where there is some, and take it back once there is some again."""
        await self.on_writer(lambda _plain: self.backend.keep_reserve())

    async def writable(self) -> None:
        """Return once writing works; at once where nothing was refused."""
        # A trial that fails starts none other, so that this ends with the first one that writes.
        while self._trial is not None:
            # Not awaited itself: whoever is cancelled here would cancel the trial of everybody.
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
                return work(self.backend.plain)
            except self.backend.refused as error:
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

        # The records of one session, not of all: a session is taken up within a second, and the whole chain
        # may have a million links.
        found = await self.read(findings)
        for finding in found:
            self.condition.note_damage(finding, finding)
        if found:
            raise damaged(self.backend.where, found[0])

    async def head(self) -> Head:
        """Return the head of the chain, which reports print; 'truepose verify --head' takes it."""
        return await self.read(lambda connection: newest_head(plain(connection)))

    @property
    def next_commit(self) -> asyncio.Event:
        """What the next commit sets; take it before a query, so that no commit falls between."""
        return self._commit

    def wake(self) -> None:
        """Wake everybody who waits for a commit."""
        # A new event at each commit instead of one that is cleared: whoever took the old one before a query
        # cannot miss the commit in between.
        self._commit.set()
        self._commit = asyncio.Event()

    def _write_in_turn(self, work: GroupWrite[One], one: One) -> "asyncio.Future[Any]":
        # The result travels by a future of the caller's own loop: a service has one, tests have others.
        done = asyncio.get_running_loop().create_future()
        self._wanted.append(PendingWrite(work, one, done))
        # The writer is woken once for all that comes until it looks. It takes the mark down before it counts
        # what waits, so that nothing which comes later stays behind.
        if not self._handed_over:
            self._handed_over = True
            self._writer.submit(self._write_wanted)
        return done

    def _announce(self, ended: Sequence[tuple[PendingWrite, Outcome]]) -> None:
        """Tell each how its write ended, unless it waits no more, and everybody that there was a commit."""
        if any(failure is None for _, (_, failure) in ended):
            self.wake()
        for wanted, (result, failure) in ended:
            # Whoever asked was cancelled. The record is kept all the same, and a repeated request finds it by
            # its key.
            if wanted.done.done():
                continue
            if failure is None:
                wanted.done.set_result(result)
            else:
                wanted.done.set_exception(failure)

    def _note_trouble(self, error: StorageUnavailableError) -> None:
        # Whoever is refused without a try hears the same kind of error as the first one: a server that is
        # away and one that refuses want different people (decision 0068).
        self._refused, self.condition.trouble = type(error), str(error)

    def _try_again_after(self, error: StorageUnavailableError) -> None:
        self._note_trouble(error)
        if self._trial is None:
            _LOG.warning("records are refused: %s", error)
            self._trial = asyncio.create_task(self._try_until_writable(), name="storage trial")

    async def _try_until_writable(self) -> None:
        try:
            while self.condition.trouble is not None:
                await asyncio.sleep(_TRIAL_S)
                try:
                    # Past the refusal above, and really to the disk: reading or an empty transaction would
                    # succeed on a full one.
                    await self._write_in_turn(alone(self.backend.write_a_little), None)
                except StorageUnavailableError as error:
                    self._note_trouble(error)
                else:
                    self.condition.trouble = None
                    _LOG.warning("records are taken again")
        finally:
            self._trial = None

    # on the writer's thread

    def _write_wanted(self) -> None:
        """Run what waits in one transaction; who comes later shares the next one."""
        self._handed_over = False
        for _ in range(0, len(self._wanted), _MOST_TOGETHER):
            # Only the writer takes from the queue, and the loop only adds to it: a deque needs no lock for
            # that.
            self._write_these([self._wanted.popleft() for _ in range(min(len(self._wanted), _MOST_TOGETHER))])

    def _write_these(self, together: Sequence[PendingWrite]) -> None:
        """Write together what does not fail, then what does, each alone: in a transaction of its own."""
        failing: list[PendingWrite] = []
        while together:
            try:
                self._write_all(together)
                break
            except GroupFailedError as error:
                failing += error.failed
                # All others in one further transaction. Each in one of its own would cost 255 commits for one
                # bad write (commit eb4a14ec).
                together = [wanted for wanted in together if wanted not in error.failed]
        for wanted in failing:
            self._write_all([wanted])

    def _write_all(self, together: Sequence[PendingWrite]) -> None:
        try:
            self._tell(together, self._write(lambda connection: run(connection, together)))
        except GroupFailedError:
            raise
        # Neither an acknowledgement nor a refusal is true: the caller would repeat a record that may be there
        # (decision 0061).
        except _DoubtError as doubt:
            self._wait_for_certainty(_Doubtful(together, doubt.result, doubt.newest))
        # Also what is no error of the database, such as a mistake in a repository: a write that ends without
        # a word would be waited for, and the session with it.
        except Exception as error:
            self._tell(together, [(None, error)] * len(together))

    def _tell(self, together: Sequence[PendingWrite], ends: Sequence[Outcome]) -> None:
        """Tell whoever waits how it ended; each loop is woken once."""
        of_loops: dict[asyncio.AbstractEventLoop, list[tuple[PendingWrite, Outcome]]] = {}
        for wanted, end in zip(together, ends, strict=True):
            of_loops.setdefault(wanted.done.get_loop(), []).append((wanted, end))
        for loop, ended in of_loops.items():
            with contextlib.suppress(RuntimeError):  # it was closed: nobody waits any more
                # Once for each loop and transaction: a wake-up for each of 256 writes was a good part of what
                # a delivery cost (decision 0067).
                loop.call_soon_threadsafe(self._announce, ended)

    def _write(self, work: Callable[[Connection], T]) -> T:
        try:
            return self._committed(work)
        except self.backend.refused as error:
            # A second attempt at most: without a reserve that is still whole the answer is no.
            if self.backend.make_room(error):
                return self._write(work)  # in the room that is free now
            raise self._noted(error) from error

    def _committed(self, work: Callable[[Connection], T]) -> T:
        self._make_ready()
        begun_s = time.perf_counter()
        transaction = self._begun()
        connection = self.backend.connection
        # Hashes rest on values as the engine keeps them, so links are made of what was written, and written
        # with it: no record is ever without its link, nor a link without its record.
        links = linking(connection)
        try:
            result = work(connection)
            self.backend.commit(transaction, links.write(plain(connection)))
        except InDoubtError as doubt:
            raise _DoubtError(result, doubt.newest) from doubt
        except BaseException:
            # The heads that it remembers are those of records that are undone now; the next record would rest
            # on one that does not exist.
            links.forget()
            transaction.rollback()
            raise
        self.commits.note(time.perf_counter() - begun_s)
        return result

    def _begun(self) -> Transaction:
        """Begin a transaction, over a new connection where the one before has ended while it lay idle."""
        try:
            return self.backend.connection.begin()
        except self.backend.refused as error:
            # A server drops connections that lie idle for long. Nothing was begun, so nobody need hear of it.
            if not self.backend.ended(error):
                raise
        self._make_ready()
        return self.backend.connection.begin()

    def _make_ready(self) -> None:
        self.backend.make_ready()
        # Asked before anything new is written: the newest link says whether the commit was made only as long
        # as nothing has come behind it.
        if self._doubtful is not None:
            self._tell_certainty(self._doubtful, self.backend.has(self._doubtful.newest))
        # After the doubt is told: whoever waits gets an answer also where another service has had the
        # database meanwhile (commit eb4a14ec).
        self.backend.require_ours()

    def _wait_for_certainty(self, doubtful: "_Doubtful") -> None:
        """Answer nobody of a commit that may have been made, and refuse others until that is known."""
        self._doubtful = doubtful
        error = ServerAwayError(_IN_DOUBT.format(self.backend.where))
        self._note_trouble(error)
        # The trial is a task, and tasks are of a loop; this runs on the writer's thread.
        doubtful.together[0].done.get_loop().call_soon_threadsafe(self._try_again_after, error)

    def _tell_certainty(self, doubtful: "_Doubtful", made: bool) -> None:
        self._doubtful = None
        refused = ServerAwayError(f"The connection to {self.backend.where} ended; nothing was kept.")
        _LOG.warning("the commit during which the connection ended was %s", "made" if made else "not made")
        self._tell(doubtful.together, doubtful.ends if made else [(None, refused)] * len(doubtful.ends))

    def _leave(self) -> None:
        """Leave the database as it should be left; what is still in doubt stays so."""
        if self._doubtful is not None:
            unknown = ServerAwayError(_IN_DOUBT.format(self.backend.where))
            self._tell(self._doubtful.together, [(None, unknown)] * len(self._doubtful.ends))
        self.backend.close()

    @contextlib.contextmanager
    def _nobody_reads(self) -> Iterator[None]:
        # All places, one after the other: no new reader begins, and each that reads is waited for.
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
            # The engine is looked up inside: the writer may have made a new one behind a file that was
            # removed.
            with self._reading, self.backend.readers.begin() as connection:
                return work(connection)
        except self.backend.refused as error:
            if again and self.backend.ended(error):  # while it lay idle, perhaps; another one may do
                return self._read(work, again=False)
            raise self._noted(error) from error

    def _noted(self, error: Exception) -> StorageError:
        found = self.backend.translated(error)
        if isinstance(found, DamagedDatabaseError):
            self.condition.note_damage("pages", str(found))
        return found

    def close(self) -> None:
        """Finish what was begun, close the database and let another service have it."""
        if self._trial is not None:
            self._trial.cancel()
        # Readers first: SQLite takes over its log and removes it when the last connection is closed, which is
        # the writer's to be.
        self._readers.shutdown()
        # Behind everything that waits, on the writer's thread: what was handed over is written before the
        # end.
        self._writer.submit(self._leave).result()
        self._shut()

    def _shut(self) -> None:
        self._readers.shutdown()
        self._writer.shutdown()


@dataclass(frozen=True, slots=True)
class _Doubtful:
    """Writes of a commit that may have been made."""

    together: Sequence[PendingWrite]
    ends: Sequence[Outcome]  # if it was
    newest: ClosingState  # link that the database has if it was


class _DoubtError(Exception):
    """Whether a commit was made is not known yet."""

    def __init__(self, result: Any, newest: ClosingState) -> None:
        super().__init__()
        self.result, self.newest = result, newest
