"""Files that somebody brings, until a campaign is made of them: a folder each beside the database.

They are no records: whoever brought them may change or throw them away, and they end by themselves. A file
is kept under a number, never under the name that somebody gave it. Nothing of it holds up the database's
writer, where a session's readings come first.
"""

import contextlib
import json
import logging
import math
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, BinaryIO, Final

from truepose.storage.documents import from_document, to_document
from truepose.storage.engine.files import write_whole
from truepose.storage.errors import ConflictError, NotFoundError, StorageUnavailableError

MOST_BYTES: Final = 64 * 2**20  # of a draft
MOST_FILES: Final = 200
# Drafts lie on the disk on which sessions keep their readings; these three bound what people may fill of it:
# 1.3 GB.
MOST_DRAFTS: Final = 20
KEPT: Final = timedelta(days=14)  # after the last change: a shift, a weekend, a week of holidays
# A draft that is over goes when it still is after so long: a clock that was set forward is set right by then.
_GRACE_S: Final = 24 * 3600.0
STATE: Final = "draft.json"
_WHAT: Final = "draft"
_LOG: Final = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class DraftFile:
    """A file of a draft."""

    number: int
    name: str
    size_bytes: int


@dataclass(frozen=True, slots=True)
class Draft:
    """Files that were brought, and what was said of them."""

    id: int
    created_at: str
    changed_at: str
    files: tuple[DraftFile, ...] = ()
    choices: dict[str, Any] = field(default_factory=dict)
    revision: int = 0  # of files and choices
    campaign_id: int | None = None  # that was made of it
    job_ids: tuple[int, ...] = ()

    @property
    def size_bytes(self) -> int:
        """How much its files are together."""
        return sum(file.size_bytes for file in self.files)

    @property
    def expires_at(self) -> str:
        """When it ends by itself."""
        return (datetime.fromisoformat(self.changed_at) + KEPT).isoformat(timespec="seconds")


class DraftFolder:
    """All drafts; every method touches the disk, so call them off the loop."""

    def __init__(self, folder: Path, now_s: Callable[[], float] = time.monotonic) -> None:
        self._folder = folder
        self._now_s = now_s
        self._over_s: dict[int, float] = {}  # when a draft was first seen to be over, by its number
        # Every method may be called from any thread of the pool, and some call others.
        self._lock = threading.RLock()

    @classmethod
    def beside(cls, database: Path) -> "DraftFolder":
        """Return the drafts of a service by the file of its database."""
        return cls(database.with_name(f"{database.name}.drafts"))

    def create(self) -> Draft:
        """Make an empty draft; raises ConflictError where too many are kept."""
        with self._lock, _told_of_disk():
            self._expire()
            numbers = self.numbers()
            if len(numbers) >= MOST_DRAFTS:
                raise ConflictError(f"{MOST_DRAFTS} drafts exist already; delete one first.")
            now = _now()
            draft = Draft(self._next_number(numbers), now, now)
            self._place(draft.id).mkdir(parents=True)
            self._write(draft)
            return draft

    def get(self, number: int) -> Draft:
        """Return a draft; raises NotFoundError, StorageUnavailableError where its state cannot be read."""
        try:
            document = json.loads((self._place(number) / STATE).read_bytes())
        # A draft whose creation was cut short has no state, and is none.
        except (FileNotFoundError, NotADirectoryError) as error:
            raise NotFoundError(_WHAT, number) from error
        except (OSError, ValueError) as error:
            raise StorageUnavailableError(f"Draft {number} cannot be read ({error}).") from error
        return from_document(Draft, document)

    def all(self) -> tuple[Draft, ...]:
        """Return all drafts that can be read, the latest first."""
        with self._lock, _told_of_disk():
            self._expire()
            return tuple(draft for number in self.numbers()[::-1] for draft in self._readable(number))

    def remove(self, number: int) -> None:
        """Throw a draft away; raises NotFoundError."""
        with self._lock, _told_of_disk():
            # Also one that cannot be read: else nobody could ever get rid of it.
            if number not in self.numbers():
                raise NotFoundError(_WHAT, number)
            shutil.rmtree(self._place(number))

    @contextlib.contextmanager
    def receiving(self, number: int) -> Iterator["Incoming"]:
        """Receive a file: it counts once `keep` is called within. Raises NotFoundError, ConflictError."""
        draft = self.get(number)
        if len(draft.files) >= MOST_FILES:
            raise ConflictError(f"A draft has {MOST_FILES} files at most; import them as a zip.")
        with _told_of_disk():
            # Received without the lock: an upload takes as long as its sender, and others go on meanwhile.
            incoming = Incoming(self, number, MOST_BYTES - draft.size_bytes)
        try:
            yield incoming
        finally:
            incoming.close()

    def remove_file(self, number: int, file: int) -> Draft:
        """Take a file out of a draft; raises NotFoundError."""
        with self._lock, _told_of_disk():
            draft = self.get(number)
            if not any(one.number == file for one in draft.files):
                raise NotFoundError("file", file)
            left = tuple(one for one in draft.files if one.number != file)
            # State first, then the file: a crash in between leaves a file that nobody counts, the other order
            # a state that names a file which is gone.
            kept = self._write(_changed(draft, files=left))
            self.path(number, file).unlink(missing_ok=True)
            return kept

    def keep_choices(self, number: int, choices: dict[str, Any]) -> Draft:
        """Keep what was said of the files; raises NotFoundError."""
        with self._lock, _told_of_disk():
            return self._write(_changed(self.get(number), choices=choices))

    def keep_made(self, draft: Draft, campaign_id: int, job_ids: tuple[int, ...]) -> Draft:
        """Keep what was made of a draft, unless it was changed meanwhile; raises NotFoundError."""
        made = replace(draft, campaign_id=campaign_id, job_ids=job_ids)
        with self._lock, _told_of_disk():
            return self._write(made) if self.get(draft.id).revision == draft.revision else made

    def path(self, number: int, file: int) -> Path:
        """Return where a file of a draft lies."""
        return self._place(number) / f"{file}.file"

    def taken_in(self, number: int, name: str, part: Path, size_bytes: int) -> Draft:
        """Count a received file in; one of the same name is replaced."""
        with self._lock:
            draft = self.get(number)
            # The new file has a number of its own and takes the place in the state at once; the bytes of the
            # old one go last. Writing over them would leave half of each after a crash.
            before = [file for file in draft.files if file.name == name]
            others = tuple(file for file in draft.files if file.name != name)
            file = DraftFile(1 + max((one.number for one in draft.files), default=0), name, size_bytes)
            changed = _changed(draft, files=(*others, file))
            # Once more, as others may have brought something meanwhile.
            if changed.size_bytes > MOST_BYTES:
                raise _too_large()
            os.replace(part, self.path(number, file.number))
            kept = self._write(changed)
            for one in before:
                self.path(number, one.number).unlink(missing_ok=True)
            return kept

    def put_back(self, member: str, data: bytes) -> None:
        """Write a file of a draft that was kept elsewhere, by its path in this folder."""
        place = self._folder / member
        with self._lock, _told_of_disk():
            place.parent.mkdir(parents=True, exist_ok=True)
            with place.open("wb") as file:
                file.write(data)
                _flush(file)

    def _place(self, number: int) -> Path:
        return self._folder / str(int(number))

    def numbers(self) -> list[int]:
        """Return the numbers of all drafts, of those too that have ended and were not looked for since."""
        if not self._folder.is_dir():
            return []
        # The folder holds `last` as well, and may hold what somebody else put there.
        return sorted(int(path.name) for path in self._folder.iterdir() if path.name.isdecimal())

    def _next_number(self, numbers: list[int]) -> int:
        """Return a number that no draft has had: an old address never shows somebody else's files."""
        # Numbers of removed drafts are in addresses that browsers keep. The largest that is there is not
        # enough: it goes with the draft.
        last, said = self._folder / "last", 0
        with contextlib.suppress(FileNotFoundError, ValueError):  # ValueError: a loss of power left it empty
            said = int(last.read_text(encoding="ascii"))
        number = 1 + max([said, *numbers])
        self._folder.mkdir(parents=True, exist_ok=True)
        write_whole(last, str(number).encode())
        return number

    def _write(self, draft: Draft) -> Draft:
        # A state is written anew at each change, and whole or not at all: a reader may come at any moment
        # without the lock.
        write_whole(self._place(draft.id) / STATE, json.dumps(to_document(draft)).encode())
        return draft

    def _readable(self, number: int) -> Iterator[Draft]:
        try:
            yield self.get(number)
        except NotFoundError:
            return  # its creation was cut short
        except StorageUnavailableError as error:
            # One that is damaged keeps nobody from the others.
            _LOG.warning("%s", error)

    def _expire(self) -> None:
        now_s = self._now_s()
        over = [number for number in self.numbers() if self._is_over(number)]
        self._over_s = {number: self._over_s.get(number, now_s) for number in over}
        for number, since_s in self._over_s.items():
            if now_s - since_s >= _GRACE_S:
                shutil.rmtree(self._place(number), ignore_errors=True)

    def _is_over(self, number: int) -> bool:
        """Whether nobody has touched a draft for so long that it ends."""
        oldest = datetime.now(UTC) - KEPT
        try:
            # ISO 8601 in UTC of one length: texts compare as their moments do.
            return self.get(number).changed_at < oldest.isoformat(timespec="seconds")
        except NotFoundError:  # its creation was cut short
            return True
        except StorageUnavailableError:  # when it was changed only its file says
            return self._written_s(number) < oldest.timestamp()

    def _written_s(self, number: int) -> float:
        try:
            return (self._place(number) / STATE).stat().st_mtime
        except OSError:
            return math.inf


class Incoming:
    """A file on its way in."""

    def __init__(self, drafts: DraftFolder, draft: int, room_bytes: int) -> None:
        self._drafts = drafts
        self._draft = draft
        self._room_bytes = room_bytes
        # In the draft's own folder, so that it gets its name by a rename and goes with the draft.
        self._part = drafts.path(draft, 0).with_name(f"{os.urandom(8).hex()}.part")
        self._file = self._part.open("wb")
        self._size_bytes = 0

    def write(self, data: bytes) -> None:
        """Take more of it; raises ConflictError where the draft becomes too large."""
        self._size_bytes += len(data)
        # Counted as it comes: what a request says of its length is the sender's word.
        if self._size_bytes > self._room_bytes:
            raise _too_large()
        with _told_of_disk():
            self._file.write(data)

    def keep(self, name: str) -> Draft:
        """Count the file in under its name; raises NotFoundError where the draft has gone."""
        with _told_of_disk():
            _flush(self._file)
            self._file.close()
            return self._drafts.taken_in(self._draft, name, self._part, self._size_bytes)

    def close(self) -> None:
        """Let go of what was not kept."""
        self._file.close()
        self._part.unlink(missing_ok=True)


def _too_large() -> ConflictError:
    return ConflictError(f"A draft has {MOST_BYTES // 2**20} MB at most; import fewer files, or a zip.")


def _changed(draft: Draft, **changes: Any) -> Draft:
    """Return a draft with changes; what was made of it before is not made of it any more."""
    now = _now()
    return replace(
        draft, **changes, changed_at=now, revision=draft.revision + 1, campaign_id=None, job_ids=()
    )


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _flush(file: BinaryIO) -> None:
    file.flush()
    os.fsync(file.fileno())


@contextlib.contextmanager
def _told_of_disk() -> Iterator[None]:
    """Say in a sentence what the disk refused."""
    try:
        yield
    # A folder that is gone is no fault of the disk: somebody threw the draft away while a file came in.
    except FileNotFoundError as error:
        raise ConflictError("The draft has been deleted in the meantime.") from error
    except OSError as error:
        raise StorageUnavailableError(
            f"The files could not be saved ({error.strerror}); free some disk space and import them again."
        ) from error
