"""The secret that PINs are mixed with: it lies in a file of its own, and in no database and no copy of one.

Who has a database alone cannot try PINs then. Who has another secret, as on another machine, cannot either:
PINs are chosen anew there. The file is made when the first PIN is chosen.
"""

import hashlib
import os
import re
import secrets
from pathlib import Path
from typing import Final

from truepose.storage.connection.sqlite.place import sync_folder
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.files.owner_alone import opened_alone, tighten

_BYTES: Final = 32
_TEXT: Final = re.compile(rf"[0-9a-f]{{{2 * _BYTES}}}\s*", re.ASCII)
_NAME_LETTERS: Final = 8


class Pepper:
    """The secret of one installation."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self._key: bytes | None = None

    @classmethod
    def beside(cls, database: Path) -> "Pepper":
        """Return the one that lies beside a database."""
        return cls(database.with_name(f"{database.name}.pins"))

    def key(self) -> bytes | None:
        """Return the secret; None where there is none yet. Raises StorageUnavailableError."""
        if self._key is None and self.file.exists():
            tighten(self.file)
            self._key = self._read()
        return self._key

    def made(self) -> bytes:
        """Return the secret, which is made where there is none; raises StorageUnavailableError."""
        found = self.key()
        if found is None:
            self._write(secrets.token_hex(_BYTES))
            self._key = found = self._read()
        return found

    def _read(self) -> bytes:
        try:
            text = self.file.read_text(encoding="ascii")
        except (OSError, ValueError) as error:
            raise self._unusable(error) from error
        if _TEXT.fullmatch(text) is None:
            raise self._unusable("it does not hold 64 hexadecimal digits")
        return bytes.fromhex(text.strip())

    def _write(self, text: str) -> None:
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
            with os.fdopen(opened_alone(self.file, flags), "w", encoding="ascii") as written:
                written.write(f"{text}\n")
                written.flush()
                os.fsync(written.fileno())
            sync_folder(self.file.parent)
        except OSError as error:
            raise self._unusable(error) from error

    def _unusable(self, why: object) -> StorageUnavailableError:
        return StorageUnavailableError(f"The secret of the PINs, {self.file}, cannot be used ({why}).")


def name_of(key: bytes) -> str:
    """Return what tells one secret from another and nothing about it."""
    return hashlib.sha256(b"name of a pepper" + key).hexdigest()[:_NAME_LETTERS]
