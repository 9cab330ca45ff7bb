"""A copy is put back: verified first, never over a database that is in use, the one before kept aside.

Beside a running service a copy can be laid ready: that one goes on as it is, and the next begins with it.
"""

import contextlib
import shutil
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from truepose.storage.backup.copying import Told, copy_database, require_copy
from truepose.storage.engine.files import sync_folder
from truepose.storage.engine.sqlite_connections import LIBRARY, opened_file
from truepose.storage.engine.sqlite_file import ServiceLock
from truepose.storage.errors import BackupError, DatabaseUsedError
from truepose.storage.integrity.database_identity import IdentityFile, digest_of
from truepose.storage.integrity.head_hash import Head, newest_head
from truepose.storage.integrity.verification import Verdict, verify_left

ASIDE: Final = "before-restore"
READY: Final = "to-restore"
_PARTS: Final = ("", "-wal", "-shm", ".seal")
_VERIFYING: Final = 0.7  # of the time that everything takes


def restore(
    copy: Path, database: Path, told: Told = lambda share, doing: None, *, replace: bool = False
) -> tuple[Head, Path | None]:
    """Put a copy in the place of a database; returns the head of its chain, and where the one before is kept.

    Raises
    ------
    DatabaseAddressError
        There is no such copy.
    BackupError
        The copy is not whole, or the disk refuses.
    DatabaseUsedError
        Records are at that place, and `replace` does not allow them to be put aside.
    DatabaseInUseError
        A service has the database open.
    """
    # Every record is read before anything is touched: a copy that is not whole must not cost the database
    # that is there.
    head = whole_copy(copy, told)
    # Restoring takes the lock of a service: a database is never exchanged under a session (decision 0054).
    lock = ServiceLock(database)  # makes an empty file where there is none
    try:
        used = _require_allowed(database, replace)
        told(_VERIFYING, "copying")
        # The copy is copied once more beside the database: a rename is only atomic within one file system,
        # and the copy itself must survive the restoring.
        with _copied(copy, database.with_name(f"{database.name}.restored"), head) as fresh:
            # Only the lock on the file itself is let go; the side file goes on keeping services off while the
            # files are exchanged.
            lock.move_to(None)  # no open file is replaced on Windows; the side file is held on
            return head, _put_in_place(fresh, database, used)
    except (OSError, LIBRARY.DatabaseError) as error:
        raise BackupError(f"{copy} cannot be restored to {database} ({error}).") from error
    finally:
        lock.release()


def lay_ready(
    copy: Path, database: Path, told: Told = lambda share, doing: None, *, replace: bool = False
) -> tuple[Head, Path]:
    """Lay a copy ready for the next start of the service; returns the head of its chain, and where it lies.

    Raises as `restore`, but also beside a service that has the database.
    """
    head = whole_copy(copy, told)
    ready = database.with_name(f"{database.name}.{READY}")
    try:
        # The service that has the lock may be writing here, so that only what must not be lost is asked: are
        # there records, and may they be put aside.
        if database.exists():
            _require_allowed(database, replace)
        told(_VERIFYING, "copying")
        with _copied(copy, database.with_name(f"{ready.name}.part"), head) as fresh:
            IdentityFile(ready).file.unlink(missing_ok=True)  # of what was laid ready before
            fresh.replace(ready)
            sync_folder(ready.parent)
        _seal(ready)
    except (OSError, LIBRARY.DatabaseError) as error:
        raise BackupError(f"{copy} cannot be prepared for {database} ({error}).") from error
    return head, ready


def put_ready_in_place(database: Path) -> tuple[Head, Path | None] | None:
    """Put what was laid ready in the place of a database; None where nothing was, else as `restore`.

    Raises BackupError where it is not whole any more, DatabaseInUseError.
    """
    ready = database.with_name(f"{database.name}.{READY}")
    if not ready.exists():
        return None
    lock = ServiceLock(database)
    try:
        # A week may lie between laying ready and the next start.
        _require_as_sealed(ready)
        with contextlib.closing(opened_file(ready)) as laid:
            head = newest_head(laid)
        require_copy(ready, head)
        lock.move_to(None)  # as above
        aside = _put_in_place(ready, database, _has_records(database))
        IdentityFile(ready).file.unlink(missing_ok=True)
        return head, aside
    # This keeps the service from starting, on purpose: somebody asked for another database, and a session
    # begun on the old one would be put aside with it at the next start.
    except (OSError, LIBRARY.DatabaseError) as error:
        raise BackupError(
            f"{ready} should be restored, but cannot be ({error}); delete it to continue with the current"
            " database."
        ) from error
    finally:
        lock.release()


def _seal(ready: Path) -> None:
    """Note beside what was laid ready what it holds."""
    seal = IdentityFile(ready)
    with contextlib.closing(opened_file(ready)) as laid:
        seal.break_open(laid)
    seal.close(digest_of(ready))


def _require_as_sealed(ready: Path) -> None:
    """Raise BackupError where a file is not what was laid ready; every record was read then."""
    sealed = IdentityFile(ready).left()
    # Nobody has sealed it: somebody was cut short after laying it ready, or an earlier version has.
    if sealed is None or sealed.sha256 is None:
        return
    if digest_of(ready) != sealed.sha256:
        raise BackupError(
            f"{ready} was changed after it was prepared; delete it to continue with the current database, or"
            " prepare it again."
        )


def whole_copy(copy: Path, told: Told) -> Head:
    """Return the head of a copy of which every record is as it was written; raises BackupError."""
    return _require_whole(verify_left(copy, lambda share: told(_VERIFYING * share, "verifying")), copy)


def _require_allowed(database: Path, replace: bool) -> bool:
    """Return whether there are records to put aside; raises DatabaseUsedError where that is not allowed."""
    used = _has_records(database)
    if used and not replace:
        raise DatabaseUsedError(
            f"{database} already contains records; '--replace' moves them aside and restores the copy."
        )
    return used


def _require_whole(verdict: Verdict, copy: Path) -> Head:
    if verdict.findings or verdict.head is None:
        raise BackupError(f"{copy} failed verification; nothing was restored. {verdict.findings[0]}")
    return verdict.head


def _has_records(database: Path) -> bool:
    """Whether anything was ever kept there; tables of another program and damage count as that."""
    # An empty file is what the lock leaves where there was no database.
    if database.stat().st_size == 0:
        return False
    with (
        contextlib.suppress(LIBRARY.DatabaseError),
        contextlib.closing(opened_file(database)) as connection,
    ):
        return connection.execute("SELECT max(id) FROM links").fetchone()[0] is not None
    return True


@contextlib.contextmanager
def _copied(copy: Path, fresh: Path, head: Head) -> Iterator[Path]:
    """Yield a copy of a copy, which is taken from there or goes."""
    fresh.unlink(missing_ok=True)
    try:
        copy_database(copy, fresh, lambda share: None)
        require_copy(fresh, head)
        yield fresh
    finally:
        fresh.unlink(missing_ok=True)


def _put_in_place(fresh: Path, database: Path, used: bool) -> Path | None:
    aside = _put_aside(database) if used else None
    # A log left by another file is not of the fresh one: SQLite would play it into it. A seal of the file
    # before would say that records are missing.
    for part in _PARTS[1:]:
        database.with_name(f"{database.name}{part}").unlink(missing_ok=True)
    # Here, and not before, the place has another database: a crash earlier leaves the one before, aside or in
    # place, and whatever was laid ready is taken up again at the next start.
    fresh.replace(database)
    sync_folder(database.parent)
    return aside


def _put_aside(database: Path) -> Path:
    """Keep a database with its log and seal; raises BackupError where no name is free."""
    stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%SZ")
    aside = database.with_name(f"{database.name}.{ASIDE}-{stamp}")
    if aside.exists():
        raise BackupError(f"{aside} already exists; nothing was restored.")
    # Without its log a database that was killed lacks its newest commits, so all parts are kept under one
    # name.
    for part in _PARTS:
        beside = database.with_name(f"{database.name}{part}")
        if beside.exists():
            shutil.move(beside, aside.with_name(f"{aside.name}{part}"))
    return aside
