"""A consistent copy of a database, also while a service writes to it, with the drafts beside it.

SQLite's own means make it from one reading transaction: it holds every record that was acknowledged before
it began, in the order of the chain up to its head, and nothing in halves. Readers hold up no writer of a
database with a write-ahead log, so that a session under way does not notice. Pages and end of the
copy's chain are looked through before it gets its name; 'truepose verify' looks at every record.

Drafts are files that somebody brought, of which no campaign is made yet. They are no records and stand in no
chain: the copy of a database is whole without them. They lie in an archive beside it, and are put back only
where there is no draft.
"""

import contextlib
import json
import logging
import re
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from truepose.messages.message import Text
from truepose.storage.documents import to_document
from truepose.storage.drafts import MOST_BYTES, STATE, Draft, DraftFolder
from truepose.storage.engine.files import make_alone, sync_file, sync_folder
from truepose.storage.engine.raw_connection import missing_protection
from truepose.storage.engine.sqlite_connections import LIBRARY, opened_file
from truepose.storage.errors import (
    BackupError,
    DatabaseAddressError,
    NotFoundError,
    StorageUnavailableError,
)
from truepose.storage.integrity.head_hash import Head, newest_head
from truepose.storage.secret_files import take_out_pins

_LOG: Final = logging.getLogger(__name__)
# Leading zeros and other digits than ASCII are left out on purpose: an archive that somebody else packed must
# name neither a folder outside the drafts nor the same file twice.
_MEMBER: Final = re.compile(rf"[1-9]\d{{0,8}}/({re.escape(STATE)}|[1-9]\d{{0,5}}\.file)", re.ASCII)
# A draft is copied without its lock: whoever uploads must not wait for a backup, and the process that copies
# need not be the service.
_TRIES: Final = 3  # of a draft that somebody changes meanwhile


def drafts_beside(copy: Path) -> Path:
    """Return where the drafts of a copy are."""
    return copy.with_name(f"{copy.name}.drafts.zip")


def copy_drafts(database: Path, copy: Path) -> int:
    """Write the drafts of a database beside its copy and return how many there are.

    Raises BackupError where the disk refuses; then none lie there.
    """
    archive = drafts_beside(copy)
    part = archive.with_name(f"{archive.name}.part")
    try:
        # Whatever comes of it, an archive from an earlier copy of this name has to go: restoring would bring
        # back drafts that the database of this copy did not have.
        archive.unlink(missing_ok=True)
        # Written under another name and renamed when it is on the disk: a copy that is cut short must not
        # leave half an archive.
        with _removed_at_the_end(part):
            count = _packed(DraftFolder.beside(database), part)
            if count:
                part.replace(archive)
        sync_folder(archive.parent)
    except OSError as error:
        raise BackupError(
            f"The drafts of {database} cannot be copied to {archive} ({error}); the records were copied."
        ) from error
    return count


def _packed(drafts: DraftFolder, archive: Path) -> int:
    """Write drafts into an archive on the disk and return how many; raises OSError."""
    count = 0
    make_alone(archive)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as written:
        for number in drafts.numbers():
            held = list(_held(drafts, number))
            for name, data in held:
                written.writestr(f"{number}/{name}", data)
            count += bool(held)
    sync_file(archive)
    return count


def restore_drafts(copy: Path, database: Path) -> int:
    """Put the drafts of a copy back where there are none; returns how many. Raises BackupError."""
    archive, drafts = drafts_beside(copy), DraftFolder.beside(database)
    # Any draft that is there stays, and then none is put back: numbers may have been given again since, and
    # somebody works on what is there.
    if not archive.exists() or drafts.numbers():
        return 0
    try:
        with zipfile.ZipFile(archive) as kept:
            # The archive is trusted with nothing but names of drafts: a zip can name any path.
            members = [one for one in kept.infolist() if _MEMBER.fullmatch(one.filename)]
            for member in sorted(
                members, key=lambda one: one.filename.endswith(STATE)
            ):  # what counts it, last
                # No draft is larger, so a larger member is no draft of ours; it would be inflated into
                # memory.
                if member.file_size <= MOST_BYTES:
                    drafts.put_back(member.filename, kept.read(member))
    except (OSError, zipfile.BadZipFile) as error:
        raise BackupError(f"{archive} cannot be restored ({error}); the records were restored.") from error
    return len(drafts.numbers())


def _held(drafts: DraftFolder, number: int) -> Iterator[tuple[str, bytes]]:
    """Yield what a draft holds at one moment.

    Nothing of one that is thrown away, changed all the time, or cannot be read.
    """
    for _ in range(_TRIES):
        try:
            draft = drafts.get(number)
            files = [
                (f"{file.number}.file", drafts.path(number, file.number).read_bytes()) for file in draft.files
            ]
        # Somebody exchanged or removed a file between the state and its bytes: what was read is of two
        # moments.
        except (FileNotFoundError, NotFoundError):
            continue
        except StorageUnavailableError as error:
            _LOG.warning("a copy is without a draft: %s", error)
            return
        yield from [*files, (STATE, _document(draft))]
        return


def _document(draft: Draft) -> bytes:
    return json.dumps(to_document(draft)).encode()


Told = Callable[[float, Text], None]  # which share is done, and of what
_PAGES: Final = 4096  # at a time, 16 MB: between two of them is told how far it is
_BESIDE: Final = ("", "-wal", "-shm", ".lock", ".seal")  # what whoever writes a database leaves
_COPYING: Final = 0.6  # of the time that everything takes


@dataclass(frozen=True, slots=True)
class Backup:
    """A copy that was verified."""

    file: Path
    size_bytes: int
    head: Head  # of the chain in it
    drafts: int  # that lie beside it


Write = Callable[[Path, Told], Head]  # everything into a file, verified; raises BackupError


def back_up(
    database: Path, target: Path, told: Told = lambda share, doing: None, *, replace: bool = False
) -> Backup:
    """Copy a database to `target` and verify the copy; raises as `write_copy`, and DatabaseAddressError."""
    if not database.is_file():
        raise DatabaseAddressError(f"There is no database {database}.")

    def write(part: Path, told: Told) -> Head:
        # A copy is a reading transaction of SQLite's own, not a copy of the file: with a write-ahead log the
        # file alone lacks the newest commits (decision 0007).
        head = copy_database(database, part, lambda share: told(_COPYING * share, "copying"))
        told(_COPYING, "verifying")
        require_copy(part, head)
        return head

    return write_copy(database, target, write, told, replace=replace)


def write_copy(database: Path, target: Path, write: Write, told: Told, *, replace: bool) -> Backup:
    """Have a copy written, verified and put at `target`, with the drafts of `database` beside it.

    Raises
    ------
    BackupError
        Something lies at `target` already and `replace` does not allow it to go, the disk refuses, or the
        copy is not what was read; or the copy is there, and its drafts are not.
    """
    # Also with `replace` the database itself is no target, by whatever name it is reached.
    if target.exists() and (not replace or (database.exists() and target.samefile(database))):
        raise BackupError(f"{target} already exists; choose another file.")
    part = target.with_name(f"{target.name}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with _removed_at_the_end(part):
            head = write(part, told)
            # Only what was verified gets the name under which a copy is looked for; until here a crash leaves
            # a `.part`.
            part.replace(target)
            sync_folder(target.parent)
    except (OSError, LIBRARY.DatabaseError) as error:
        raise BackupError(f"{database} cannot be copied to {target} ({error}); nothing was kept.") from error
    # Drafts come last: they are no records, and the copy of the records is complete without them.
    drafts = copy_drafts(database, target)
    told(1.0, "verified")
    return Backup(target, target.stat().st_size, head, drafts)


def copy_database(database: Path, target: Path, told: Callable[[float], None]) -> Head:
    """Write everything that a database holds into one file, on the disk, and return the head of its chain."""
    make_alone(target)

    def copied(_status: int, left: int, of: int) -> None:
        told(1.0 - left / max(of, 1))

    with (
        contextlib.closing(opened_file(database)) as source,
        contextlib.closing(LIBRARY.connect(target)) as copy,
    ):
        # The head is read in the transaction from which the pages are copied. Read outside, it could be of
        # another commit, and the copy would be refused for records that came in between.
        source.execute("BEGIN")
        head = newest_head(source)
        source.backup(copy, pages=_PAGES, progress=copied)
        # One file that can be read from wherever it lies; a service opens its log anew.
        copy.execute("PRAGMA journal_mode=DELETE")
        copy.execute("PRAGMA secure_delete=ON")  # nor is left what was written before in its place
        # PINs leave with no copy, whether revoked or not: a copy lies on other disks, and a PIN of a few
        # digits is found from its hash alone (commit 78613b0d).
        with copy:
            take_out_pins(copy, revoked_only=False)
    # The library syncs what it commits; the pages that `backup` wrote are ours to sync before the file gets
    # its name.
    sync_file(target)
    return head


def require_copy(file: Path, head: Head) -> None:
    """Raise BackupError where the pages of a copy are not whole, or its chain ends otherwise."""
    with contextlib.closing(opened_file(file)) as copy:
        found = [*_amiss(copy, head)]
    if found:
        raise BackupError(f"The copy {file} differs from the database: {found[0]} Nothing was kept.")


def _amiss(copy: Any, head: Head) -> Iterator[str]:
    for (said,) in copy.execute("PRAGMA integrity_check(1)"):
        if bytes(said) != b"ok":
            yield f"{bytes(said).decode(errors='replace')}."
    # A copy without its triggers would be taken for a database and could be changed from then on.
    yield from missing_protection(copy)
    if newest_head(copy) != head:
        yield "The newest records are not those of the database."


@contextlib.contextmanager
def _removed_at_the_end(part: Path) -> Iterator[None]:
    part.unlink(missing_ok=True)
    try:
        yield
    finally:
        # Opening a file for writing leaves files beside it that the database's name would claim later.
        for ending in _BESIDE:
            part.with_name(f"{part.name}{ending}").unlink(missing_ok=True)
