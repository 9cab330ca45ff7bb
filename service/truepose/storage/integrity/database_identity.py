"""What lies beside a database and says how it was left: the newest link, and a digest of the whole file.

The newest link is noted after each commit, without waiting for the disk: after a killed service the database
holds at least that much, so a log that was cut, an older copy and newest records that were taken out show.
The digest is written when the service ends in order. Whatever bit is changed while no service has the
database open shows by it, also where SQLite keeps nothing.
"""

import contextlib
import hashlib
import json
import os
from dataclasses import asdict, dataclass, replace
from io import BufferedReader
from pathlib import Path
from typing import Any, Final

from truepose.storage.engine.files import opened_alone

_LENGTH: Final = 256  # of the line, so that it is written over in place


@dataclass(frozen=True, slots=True)
class ClosingState:
    """How a database was left."""

    link: int = 0
    hash: str = ""
    sha256: str | None = None  # of the file; None: a service has it open, or was killed


class IdentityFile:
    """The file beside one database; only the service that holds the database writes it."""

    def __init__(self, database: Path) -> None:
        self.file = database.with_name(f"{database.name}.seal")
        self.noted = ClosingState()
        self._opened: int | None = None

    def left(self) -> ClosingState | None:
        """Return how the database was left; None where nobody said."""
        try:
            # What cannot be read is as good as absent: whoever puts an older copy back removes the file, and
            # a start must not fail for it.
            return ClosingState(**json.loads(self.file.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError):
            return None

    def break_open(self, connection: Any) -> None:
        """Say that a service has the database open, from now on."""
        with contextlib.suppress(OSError):  # it is a watchman, not a record
            self._opened = opened_alone(self.file, os.O_RDWR | os.O_CREAT)
            # Without a digest from now on: a service that is killed leaves the newest link alone, which the
            # database has to hold.
            self._write(newest_link(connection))
            # Once, at the start: should the power go, the file must not speak of the digest of a database
            # that was written to since. The links noted later may be lost; each only makes the check
            # stricter.
            os.fsync(self._opened)

    def note(self, newest: ClosingState) -> None:
        """Note the newest link, which is committed; whatever fails here, the records are kept."""
        # A trial, and a write that keeps nothing, add no link.
        if newest != self.noted:
            with contextlib.suppress(OSError):
                self._write(newest)

    def close(self, sha256: str | None) -> None:
        """Say that nobody has the database open; seal it where a digest of the file is given."""
        if sha256 is not None:
            with contextlib.suppress(OSError):
                self._write(replace(self.noted, sha256=sha256))
        if self._opened is not None:
            os.close(self._opened)
            self._opened = None

    def _write(self, left: ClosingState) -> None:
        self.noted = left
        if self._opened is not None:
            # One length for all: a shorter line over a longer one would leave the end of the latter behind
            # it.
            line = json.dumps(asdict(left)).ljust(_LENGTH - 1) + "\n"
            os.lseek(self._opened, 0, os.SEEK_SET)
            os.write(self._opened, line.encode())


def newest_link(connection: Any) -> ClosingState:
    """Return the newest link that a plain connection sees."""
    row = connection.execute("SELECT id, hash FROM links ORDER BY id DESC LIMIT 1").fetchone()
    return ClosingState() if row is None else ClosingState(row[0], row[1].hex())


def digest(opened: BufferedReader) -> str:
    """Return the SHA-256 of a file that is open at its beginning; raises OSError."""
    return hashlib.file_digest(opened, "sha256").hexdigest()


def digest_of(file: Path) -> str:
    """Return the SHA-256 of a file; raises OSError."""
    with file.open("rb") as opened:
        return digest(opened)


def has_link(connection: Any, left: ClosingState) -> bool:
    """Whether a database holds the newest link that it was left with."""
    row = connection.execute("SELECT hash FROM links WHERE id = ?", (left.link,)).fetchone()
    return left.link == 0 or (row is not None and row[0].hex() == left.hash)
