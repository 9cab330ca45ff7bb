"""A SQLite file that this service holds, with everything that lies beside it.

The reserve is a file of 16 MiB, which are given up where a commit finds no room, so that what is under way is
brought to its end: some eight thousand readings fit into them. As long as they are given up nothing new
begins; once there is room again, they are taken back.
"""

import contextlib
import logging
import os
import shutil
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Connection
from sqlalchemy.engine import Transaction

from truepose.storage.engine.address import database_file
from truepose.storage.engine.backend import (
    RESERVE_IN_USE,
    Alone,
    Condition,
    DatabaseBackend,
    DatabaseObservation,
)
from truepose.storage.engine.files import make_alone, opened_alone
from truepose.storage.engine.raw_connection import missing_protection
from truepose.storage.engine.schema import bring_up_to_date
from truepose.storage.engine.sqlite_connections import (
    REFUSED,
    reading_engine,
    refused_at_opening,
    says_full,
    translate_error,
    writing_engine,
)
from truepose.storage.engine.sqlite_file import DatabaseFile, ServiceLock
from truepose.storage.errors import StorageError
from truepose.storage.integrity.database_identity import ClosingState, IdentityFile, newest_link
from truepose.storage.integrity.verification import note_how_it_was_left

_BYTES: Final = 16 * 2**20
_ELSE_FREE: Final = 32 * 2**20  # of the disk, beside the reserve: others live there too


class Reserve:
    """The file that is given up; taken and given up on the writer's thread."""

    def __init__(self, database: Path) -> None:
        self.file = database.with_name(f"{database.name}.reserve")
        self.used = False  # given up, and not taken back yet

    def take(self) -> None:
        """Take the room where it is not taken; where there is none to spare, nothing happens."""
        if self._is_whole:
            return
        with contextlib.suppress(OSError):
            # The last megabytes of a disk are left to others: a reserve that fills the disk would be the
            # trouble that it is kept for.
            if shutil.disk_usage(self.file.parent).free < _BYTES + _ELSE_FREE:
                return
            self._allocate()
            self.used = False

    def give_up(self) -> bool:
        """Give the room back to the disk; returns whether there was any."""
        # Half a file is given up as well, and does not count: the commit that is made again would not find
        # the room that it was promised.
        whole = self._is_whole
        self.release()
        self.used = self.used or whole
        return whole

    def release(self) -> None:
        """Give the room back, as nobody needs it any more."""
        with contextlib.suppress(OSError):
            self.file.unlink(missing_ok=True)

    @property
    def _is_whole(self) -> bool:
        with contextlib.suppress(OSError):
            return self.file.stat().st_size == _BYTES
        return False

    def _allocate(self) -> None:
        with open(self.file, "wb", opener=opened_alone) as file:
            if hasattr(os, "posix_fallocate"):
                # Blocks, not a length: a file with a hole takes no room until it is written to.
                os.posix_fallocate(file.fileno(), 0, _BYTES)
            else:
                file.write(bytes(_BYTES))


_LOG: Final = logging.getLogger(__name__)
_CHECKPOINTS: Final = "PRAGMA wal_autocheckpoint=1000"  # the library's own choice


class SQLiteFile(DatabaseBackend):
    """Readers see the last commit (WAL); a commit returns when it is on the disk (`synchronous=FULL`)."""

    refused = REFUSED

    def __init__(self, url: str, condition: Condition, alone: Alone) -> None:
        file = database_file(url)
        super().__init__(url, file, str(file), condition, alone)
        self.reserve = Reserve(file)
        self._seal = IdentityFile(file)
        # Read before anything is opened: opening the database breaks the seal.
        self.left = self._seal.left()  # how the service before left the file; None where it did not say
        self._seen: tuple[DatabaseFile, int] | None = None  # where the file lay, and the version of others

    def open(self) -> str:
        """Take the lock, open everything, bring the schema up to date and return it; raises StorageError."""
        self._lock = ServiceLock(self.file)
        try:
            make_alone(self.file)  # log and index beside it get the rights that it has
            return self._open()
        except BaseException:
            self._lock.release()
            raise

    def _open(self) -> str:
        log = self.file.with_name(f"{self.file.name}-wal")
        # Before the database is opened, which makes a log of its own.
        log_bytes = log.stat().st_size if log.exists() else 0
        try:
            self._connect()
        except REFUSED as error:
            raise refused_at_opening(self.file, error) from error
        try:
            if self.left is not None and self.left.sha256 is not None:  # until the file was compared with it
                # The file must not change before it was compared with its digest, and the service is ready
                # before that. What is written meanwhile stays in the log.
                self.plain.execute("PRAGMA wal_autocheckpoint=0")
            with self.connection.begin():
                schema = bring_up_to_date(self.connection, self.where)
            note_how_it_was_left(self.plain, self.file, self.left, log_bytes, self.condition)
            # After the schema: migrations add links, and the noted one has to be the newest.
            self._seal.break_open(self.plain)
        except REFUSED as error:
            self.connection.close()
            raise refused_at_opening(self.file, error) from error
        except BaseException:
            self.connection.close()
            raise
        self.place = DatabaseFile(self.file)
        return schema

    def _connect(self) -> None:
        self._write_engine = writing_engine(self.file)
        self.readers = reading_engine(self.file)
        self.connection = self._write_engine.connect()

    def make_ready(self) -> None:
        """See that the database lies at its place with its log, and bring it back where it was removed."""
        if self.connection.closed:  # it could not be opened anew when it had to be
            # A transaction before this one could not open the file; without a new try nothing would ever be
            # written again.
            self._connect()
        if self.place.removed:
            # From the connection that still has the removed file open: everything that was acknowledged is in
            # it (decision 0024).
            lock = self.place.restore(self.plain)
            self._reconnect()
            # Last, since closing the old descriptor drops the locks that SQLite has on that file: nothing of
            # it may be open by then.
            self._lock.move_to(lock)
            _LOG.warning("the database %s was removed while it was open; it was written anew", self.file)
        elif self.place.log_removed:
            # Over the old log, which lives on as long as it is open: what is in no other file goes into the
            # database first.
            self.plain.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._reconnect()
            _LOG.warning("the log of %s was removed while it was open; a new one was started", self.file)

    def _reconnect(self) -> None:
        """Open everything anew, while nobody reads."""
        # A reader that kept the removed file open would go on seeing it, and never a later commit.
        with self._alone():
            self.readers.dispose()
            self.connection.close()
            self._write_engine.dispose()
            self.place = DatabaseFile(self.file)
            self._connect()

    def require_ours(self) -> None:
        """Do nothing: the lock on the file is never lost."""

    def commit(self, transaction: Transaction, newest: ClosingState) -> None:
        """Commit and note the newest link; raises what the library raises, and then nothing was kept."""
        # The link is noted after the commit and never before: a note of what was refused would be missed at
        # the next start.
        transaction.commit()
        self._seal.note(newest)

    @property
    def plain(self) -> Any:
        """The library's own connection, for what is done outside transactions."""
        return self.connection.connection.dbapi_connection

    def translated(self, error: Exception) -> StorageError:
        """Return what the library raised as an error of the storage."""
        return translate_error(self.file, error)

    def make_room(self, error: Exception) -> bool:
        """Give up the reserve where the disk is full; returns whether there was any."""
        # The commit is made once more in the room that is free now: no session waits that can be brought to
        # its end (decision 0054).
        if not (says_full(error) and self.reserve.give_up()):
            return False
        self.condition.low = RESERVE_IN_USE
        _LOG.error("%s", RESERVE_IN_USE)
        return True

    def keep_reserve(self) -> None:
        """Take room for a full disk where there is some, and take it back once there is some again."""
        self.reserve.take()
        if not self.reserve.used:
            self.condition.low = None

    @property
    def reserve_used(self) -> bool:
        """Whether the reserve is given up."""
        return self.reserve.used

    def write_a_little(self, connection: Connection) -> None:
        """Write the header's field for the application's use."""
        count = int(connection.exec_driver_sql("PRAGMA user_version").scalar() or 0)
        # A field of the file's header that SQLite leaves to applications: a trial has to reach the disk and
        # must not be a record.
        connection.exec_driver_sql(f"PRAGMA user_version = {(count + 1) % 2**31}")

    def look(self) -> DatabaseObservation:
        """Return whether others' commits have raised the version since the last look, and what is missing."""
        # It changes with commits of other connections only, hence not with those of this one, which alone
        # writes.
        others = int(self.plain.execute("PRAGMA data_version").fetchone()[0])
        before, self._seen = self._seen, (self.place, others)
        # A file that was written anew, or opened anew, counts from the beginning.
        foreign = before is not None and before[0] is self.place and before[1] != others
        return DatabaseObservation(foreign, tuple(missing_protection(self.plain)))

    def changed_since_left(self) -> str | None:
        """Compare the file with the digest that the service before left; None where it left none."""
        if self.left is None or self.left.sha256 is None:
            return None
        place, found = self.place, ""
        with contextlib.suppress(OSError):
            found = self._lock.digest()
        if found == self.left.sha256 or self.place is not place:  # written anew meanwhile
            return None
        return (
            f"The file {self.file} was changed while no service had it open; "
            "'truepose verify' shows whether records are, too."
        )

    def resume(self) -> None:
        """Take over from the log into the file, which was not to change until it was compared."""
        self.plain.execute(_CHECKPOINTS)

    def size_bytes(self) -> int:
        """Return the size of the file and its log."""
        files = (self.file, self.file.with_name(f"{self.file.name}-wal"))
        return sum(file.stat().st_size for file in files if file.exists())

    def close(self) -> None:
        """Bring the file back where it was removed since the last look, seal it and let it go."""
        try:
            # A database that was removed since the last look is brought back before the service ends:
            # afterwards nobody has it open any more.
            self.make_ready()
            self._seal.note(newest_link(self.plain))  # also of records that came past `commit`
        except (StorageError, *REFUSED) as error:
            _LOG.error("the database is not as it should be left: %s", error)
        self.readers.dispose()
        self.connection.close()
        self._write_engine.dispose()
        self.reserve.release()
        self._seal.close(self._digest_to_leave())
        # Last: until here another service would find a file that is still being changed.
        self._lock.release()

    def _digest_to_leave(self) -> str | None:
        """Return the digest of the file as the next service finds it; None where no seal may vouch for it."""
        # Only of a file that is at its place with everything in it, and of which no damage is known: of
        # another one the next start would be told that it was changed.
        if self.place.lies_alone and not self.condition.damaged:
            with contextlib.suppress(OSError):
                return self._lock.digest()
        return None
