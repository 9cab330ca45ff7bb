"""What was drawn of records, until something newer needs its room: a folder beside the database.

Nothing of it is a record: all of it can be drawn again. So the folder may be thrown away at any time, is in
no copy of the database, and a disk that is nearly full gets nothing of it. A file is named after what it was
drawn of and begins with the hash of what it holds: one that a lost power cut short is none.
"""

import contextlib
import hashlib
import os
import shutil
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Final

MOST_BYTES: Final = 64 * 2**20  # some five hundred pages and reports
_ROOM_BYTES: Final = 512 * 2**20  # that the disk has left for records whatever is kept here
_HASH_BYTES: Final = hashlib.sha256().digest_size


@dataclass(frozen=True, slots=True)
class Drawn:
    """A page, a part of one or a printed report, and the hash that names its content."""

    body: bytes
    sha256: str


class DrawnFolder:
    """What was drawn; every method touches the disk, so call them off the loop."""

    def __init__(self, folder: Path, most_bytes: int = MOST_BYTES, room_bytes: int = _ROOM_BYTES) -> None:
        self._folder = folder
        self._most_bytes = most_bytes
        self._room_bytes = room_bytes
        self._lock = threading.Lock()

    @classmethod
    def beside(cls, database: Path) -> "DrawnFolder":
        """Return what a service drew by the file of its database."""
        return cls(database.with_name(f"{database.name}.drawn"))

    def get(self, of: str) -> Drawn | None:
        """Return what was drawn of something; None where it was not, or is not kept any more."""
        file = self._file(of)
        try:
            kept = file.read_bytes()
            os.utime(file)  # what is looked at stays longest
        except OSError:
            return None
        drawn = drawn_of(kept[_HASH_BYTES:])
        return drawn if kept[:_HASH_BYTES].hex() == drawn.sha256 else None

    def keep(self, of: str, drawn: Drawn) -> None:
        """Keep what was drawn, if the disk has room to spare."""
        with self._lock, contextlib.suppress(OSError):
            self._folder.mkdir(mode=0o700, exist_ok=True)
            if shutil.disk_usage(self._folder).free < self._room_bytes:
                return
            part = self._folder / "part"
            part.write_bytes(bytes.fromhex(drawn.sha256) + drawn.body)
            os.replace(part, self._file(of))
            self._make_room()

    def _make_room(self) -> None:
        """Remove what nobody has looked at for longest, down to what may be kept."""
        newest_first = sorted(
            (
                (entry.stat().st_mtime_ns, entry.stat().st_size, entry.path)
                for entry in os.scandir(self._folder)
            ),
            reverse=True,
        )
        kept_bytes = 0
        for _, size_bytes, path in newest_first:
            kept_bytes += size_bytes
            if kept_bytes > self._most_bytes:
                os.unlink(path)

    def _file(self, of: str) -> Path:
        return self._folder / hashlib.sha256(of.encode()).hexdigest()


def drawn_of(body: bytes) -> Drawn:
    """Return what was drawn with its hash."""
    return Drawn(body, hashlib.sha256(body).hexdigest())
