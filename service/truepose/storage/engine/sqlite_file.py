"""The file of an open database: the lock that keeps a second service off it, and its place on the disk.

SQLite itself would let two services write in turns, and each would move its own robot. Two locks are held
for life, and the operating system releases both with the process, however that ends:

- An exclusive transaction on a side file, wherever SQLite works.
- On Linux and Windows, a lock on the database file itself: whoever comes by another path, a hard link, a
  bind mount, from another container, or after the side file is gone, meets the same file. SQLite's locks are
  of another kind and never meet it. macOS has none that does not get in their way.

Closing any descriptor of the database file drops SQLite's own locks on it, except on Windows: what looks at
the database next takes its log for one that nobody uses, and removes it. So the service opens the file once,
for the lock, closes it last, and reads it over that descriptor.

A file that is removed lives on as long as somebody has it open, and everything that was acknowledged is in
it. So it is written anew at its place, which loses nothing; where something else lies there by now, that is
left alone and nothing is written until it is gone. A write-ahead log that is removed takes with it whatever
is in no other file; so everything is brought into the database and a new log is begun.
"""

import contextlib
import ctypes
import errno
import os
import sys
import threading
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from truepose.storage.engine.files import make_alone, opened_alone, put_new, sync_file, tighten
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import DatabaseInUseError, StorageUnavailableError
from truepose.storage.integrity.database_identity import digest

_TAKEN: Final = 33  # ERROR_LOCK_VIOLATION
_FAR: Final = 1 << 30  # upper half of a position: nobody may read a locked byte, and no file goes so far


def file_lock(system: str = sys.platform) -> Callable[[int], None]:
    """Return what locks an open file, or does nothing where the system has no such lock.

    It raises BlockingIOError where somebody else has the lock, OSError where the file system refuses.
    """
    # Nothing on macOS: its locks get in the way of SQLite's own.
    return {"linux": _flock, "win32": _lock_far_byte}.get(system, lambda file: None)


def _flock(file: int) -> None:
    import fcntl

    # `flock` and not `fcntl.lockf`: the latter is of the kind that SQLite uses, and goes with any descriptor
    # of the file that the process closes.
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _lock_far_byte(file: int) -> None:
    windows: Any = ctypes
    kernel = windows.WinDLL("kernel32", use_last_error=True)
    handle = import_module("msvcrt").get_osfhandle(file)
    # Not msvcrt.locking: its positions end at 2 GB, within what a database may hold.
    if not kernel.LockFile(ctypes.c_void_p(handle), 0, _FAR, 1, 0):
        code = windows.get_last_error()
        kind = BlockingIOError if code == _TAKEN else OSError
        raise kind(errno.EACCES, f"Windows does not lock it, error {code}")


_BESIDE: Final = ("-wal", "-shm", "-journal", ".seal", ".reserve")  # copied here by somebody, perhaps


class ServiceLock:
    """Held from construction to `release`; raises DatabaseInUseError when somebody else holds it."""

    def __init__(self, database: Path) -> None:
        self._file: int | None = None
        self._turn = threading.Lock()  # whoever reads over the descriptor, or exchanges it
        # The side file first: within one process, opening and closing the database would drop SQLite's locks.
        self._side = _locked_side_file(database)
        try:
            self._file = locked_file(database)
        except BaseException:
            self._side.close()
            raise

    def move_to(self, file: int | None) -> None:
        """Go over to a file that is locked already and takes the place of the one before."""
        # The new lock is held before the old one is let go.
        with self._turn:
            before, self._file = self._file, file
            if before is not None:
                os.close(before)

    def digest(self) -> str:
        """Return the SHA-256 of the locked file; takes its time, on any thread. Raises OSError."""
        with self._turn:
            if self._file is None:
                raise FileNotFoundError(errno.ENOENT, "the lock was released")
            with open(self._file, "rb", closefd=False) as opened:
                opened.seek(0)
                return digest(opened)

    def release(self) -> None:
        """Let another service have the database."""
        self.move_to(None)
        self._side.close()


def locked_file(database: Path) -> int:
    """Return a descriptor of the database file, which is made where there is none, that holds its lock.

    Raises DatabaseInUseError where another service holds it.
    """
    try:
        # Made where there is none: the lock has to be there before the first service makes a database.
        file = opened_alone(database, os.O_RDWR | os.O_CREAT)
    except OSError as error:
        raise _unwritable(database, error) from error
    try:
        file_lock()(file)
    except OSError as error:
        os.close(file)
        raise (
            _in_use(database) if isinstance(error, BlockingIOError) else _unwritable(database, error)
        ) from error
    return file


def _locked_side_file(database: Path) -> Any:
    try:
        database.parent.mkdir(parents=True, exist_ok=True)
        # Rights are tightened before the database is opened: its log gets those of the file.
        for part in ("", *_BESIDE):
            tighten(database.with_name(f"{database.name}{part}"))
        make_alone(Path(f"{database}.lock"))
        # check_same_thread off: opened by whoever starts the service, released by whoever stops it.
        side = LIBRARY.connect(f"{database}.lock", timeout=0.0, check_same_thread=False, isolation_level=None)
    except (OSError, LIBRARY.OperationalError) as error:
        raise _unwritable(database, error) from error
    try:
        # Held for life and never committed. Whatever ends the process ends the transaction, so that no stale
        # lock is left behind (decision 0007).
        side.execute("BEGIN EXCLUSIVE")
    except LIBRARY.DatabaseError as error:
        side.close()
        raise (_in_use(database) if "locked" in str(error) else _unwritable(database, error)) from error
    return side


def _in_use(database: Path) -> DatabaseInUseError:
    return DatabaseInUseError(
        f"The database {database} is in use by another truepose service; "
        "stop that one, or choose another file with --database."
    )


def _unwritable(database: Path, error: Exception) -> StorageUnavailableError:
    return StorageUnavailableError(
        f"The database {database} cannot be written ({error}); check the folder and its permissions."
    )


Identity = tuple[int, int]  # device and number of the file on it


class DatabaseFile:
    """Where the database lies; asked by the writer's thread before each transaction."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._log = file.with_name(f"{file.name}-wal")
        self._is = _identity(file)
        self._log_is = _identity(self._log)

    @property
    def removed(self) -> bool:
        """Whether nothing lies there any more; raises StorageUnavailableError where something else does."""
        found = _identity(self._file)
        # By device and inode: a file that was put here under the same name is another one, whatever is in it.
        if found is not None and found != self._is:
            raise StorageUnavailableError(
                f"Another file lies at {self._file} in place of the open database; move it, and "
                "the service writes its own there again."
            )
        return found is None

    @property
    def lies_alone(self) -> bool:
        """Whether the file is at its place and everything is in it."""
        return _identity(self._file) == self._is and _identity(self._log) is None

    @property
    def log_removed(self) -> bool:
        """Whether the write-ahead log is gone from its place."""
        found = _identity(self._log)
        # SQLite makes the log with the first transaction; there may be none when the database is opened.
        if self._log_is is None:
            self._log_is = found
        return found != self._log_is

    def restore(self, connection: Any) -> int:
        """Write the database anew from a connection that has it open; returns the lock on the new file.

        Raises StorageUnavailableError where that is not possible; then nothing lies there.
        """
        copy = self._file.with_name(f"{self._file.name}.rescued")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            copy.unlink(missing_ok=True)
            # Under another name, and renamed when it is on the disk and locked: a half-written database must
            # never lie in this place, nor one that another service could take.
            _copy(connection, copy)
            lock = locked_file(copy)
            try:
                self._put_back(copy)
            except BaseException:
                os.close(lock)
                raise
        except (OSError, LIBRARY.DatabaseError) as error:
            raise StorageUnavailableError(
                f"The database {self._file} was removed and cannot be rewritten ({error}); nothing "
                "is lost while the service runs. Make its folder writable and free space there."
            ) from error
        return lock

    def _put_back(self, copy: Path) -> None:
        # Copying takes seconds, in which somebody may have put a file here: neither that nor its log is ours.
        if not self.removed:
            raise FileExistsError(errno.EEXIST, "it lies there again")
        for leftover in (self._log, self._file.with_name(f"{self._file.name}-shm")):
            leftover.unlink(missing_ok=True)  # of the file that was removed: not of this one
        put_new(copy, self._file)


def _identity(file: Path) -> Identity | None:
    with contextlib.suppress(OSError):
        found = os.stat(file)
        return found.st_dev, found.st_ino
    return None


def _copy(connection: Any, target: Path) -> None:
    make_alone(target)
    copy = LIBRARY.connect(target)
    try:
        connection.backup(copy)
    finally:
        copy.close()
    sync_file(target)
