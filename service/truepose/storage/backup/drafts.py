"""Drafts beside a copy: files that somebody brought, of which no campaign is made yet.

They are no records and stand in no chain: the copy of a database is whole without them. They lie in an
archive beside it, and are put back only where there is no draft.
"""

import json
import os
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from truepose.storage.connection.sqlite.place import sync_folder
from truepose.storage.documents import to_document
from truepose.storage.errors import BackupError, NotFoundError
from truepose.storage.files.drafts import MOST_BYTES, STATE, Draft, DraftFolder
from truepose.storage.files.owner_alone import make_alone

_MEMBER: Final = re.compile(rf"[1-9]\d{{0,8}}/({re.escape(STATE)}|[1-9]\d{{0,5}}\.file)", re.ASCII)
_TRIES: Final = 3  # of a draft that somebody changes meanwhile


def drafts_beside(copy: Path) -> Path:
    """Return where the drafts of a copy are."""
    return copy.with_name(f"{copy.name}.drafts.zip")


def copy_drafts(database: Path, copy: Path) -> int:
    """Write the drafts of a database beside its copy and return how many there are; raises OSError."""
    archive = drafts_beside(copy)
    drafts, count = DraftFolder.beside(database), 0
    part = archive.with_name(f"{archive.name}.part")
    make_alone(part)
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as written:
        for number in drafts.numbers():
            held = list(_held(drafts, number))
            for name, data in held:
                written.writestr(f"{number}/{name}", data)
            count += bool(held)
    with part.open("rb+") as whole:
        os.fsync(whole.fileno())
    if count:
        part.replace(archive)
    else:
        part.unlink()
        archive.unlink(missing_ok=True)
    sync_folder(archive.parent)
    return count


def restore_drafts(copy: Path, database: Path) -> int:
    """Put the drafts of a copy back where there are none; returns how many. Raises BackupError."""
    archive, drafts = drafts_beside(copy), DraftFolder.beside(database)
    if not archive.exists() or drafts.numbers():
        return 0
    try:
        with zipfile.ZipFile(archive) as kept:
            members = [one for one in kept.infolist() if _MEMBER.fullmatch(one.filename)]
            for member in sorted(
                members, key=lambda one: one.filename.endswith(STATE)
            ):  # what counts it, last
                if member.file_size <= MOST_BYTES:
                    drafts.put_back(member.filename, kept.read(member))
    except (OSError, zipfile.BadZipFile) as error:
        raise BackupError(f"{archive} cannot be restored ({error}); the records are.") from error
    return len(drafts.numbers())


def _held(drafts: DraftFolder, number: int) -> Iterator[tuple[str, bytes]]:
    """Yield what a draft holds at one moment; nothing of one that is thrown away or changed all the time."""
    for _ in range(_TRIES):
        try:
            draft = drafts.get(number)
            files = [
                (f"{file.number}.file", drafts.path(number, file.number).read_bytes()) for file in draft.files
            ]
        except (FileNotFoundError, NotFoundError):
            continue
        yield from [*files, (STATE, _document(draft))]
        return


def _document(draft: Draft) -> bytes:
    return json.dumps(to_document(draft)).encode()
