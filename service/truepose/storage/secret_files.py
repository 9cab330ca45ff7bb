"""Secrets in files beside the database, and hashes of PINs that are taken out of it.

The file of a running service tells commands of the same machine where it is and what opens it. Who can read
that file can read the database beside it as well: it opens no more than that does. It is there as long as
the service runs, and its secret is another one at each start.

PINs are mixed with a secret, the pepper, that is in no database and no copy of one. Who has a database alone
cannot try PINs then. Who has another secret, as on another machine, cannot either: PINs are chosen anew
there. The file is made when the first PIN is chosen.

A PIN has few digits, and whoever has its hash finds it. So hashes that count no more are taken out of the
database. This is the one thing that is ever taken out of a record: what is left opens nothing and says so,
its link stays as it is, and whoever verifies passes it over.
"""

import contextlib
import hashlib
import json
import os
import re
import secrets
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from truepose.storage.engine.files import tighten, write_new
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.migrations.triggers import server_trigger, trigger, trigger_name

_OWNER_ALONE: Final = 0o600


@dataclass(frozen=True, slots=True)
class ReachedService:
    """How the service of a database is reached from its own machine."""

    url: str
    secret: str
    certificate: str | None = None  # file that it shows, where it speaks TLS


@contextlib.contextmanager
def publish_endpoint(database: Path, service: ReachedService) -> Iterator[None]:
    """Say beside a database how its service is reached, for as long as the context lasts."""
    place = _place(database)
    place.unlink(missing_ok=True)  # of a service that was killed; its owner may have been another
    # Made anew with its mode, never written into what is there: that file could be somebody else's, or a link
    # that leads elsewhere.
    file = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_EXCL, _OWNER_ALONE)
    with os.fdopen(file, "w", encoding="utf-8") as told:
        json.dump(asdict(service), told)
    try:
        yield
    finally:
        place.unlink(missing_ok=True)


def service_of(database: Path) -> ReachedService | None:
    """Return how the service of a database is reached; None where none says so, or not to whoever asks."""
    try:
        return ReachedService(**json.loads(_place(database).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def _place(database: Path) -> Path:
    return database.with_name(f"{database.name}.machine")


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
            # Read back: only a secret that can be read after a restart may be mixed into a PIN.
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
            # A secret that a loss of power takes, or that another process exchanges, would make every PIN
            # worthless that was chosen with it.
            write_new(self.file, f"{text}\n".encode("ascii"))
        except OSError as error:
            raise self._unusable(error) from error

    def _unusable(self, why: object) -> StorageUnavailableError:
        return StorageUnavailableError(f"The secret of the PINs, {self.file}, cannot be used ({why}).")


def name_of(key: bytes) -> str:
    """Return what tells one secret from another and nothing about it."""
    return hashlib.sha256(b"name of a pepper" + key).hexdigest()[:_NAME_LETTERS]


TAKEN_OUT: Final = "taken out"
PIN: Final = "pin"  # kind of a credential
_TABLE: Final = "credentials"
_LEFT: Final = f"FROM {_TABLE} WHERE kind = '{PIN}' AND hash <> '{TAKEN_OUT}'"
_REVOKED: Final = " AND id IN (SELECT credential_id FROM revocations)"


def take_out_pins(connection: Any, *, revoked_only: bool) -> int:
    """Take the hashes of PINs out of a database, within the caller's transaction; returns how many.

    `connection` is the library's own (`connection.plain`). Raises what the library raises.
    """
    these = _LEFT + (_REVOKED if revoked_only else "")
    count = int(connection.execute(f"SELECT count(*) {these}").fetchone()[0])
    # Without this each revocation of anything would drop and make a trigger.
    if not count:
        return 0
    on_server = hasattr(connection, "server")
    of = f" ON {_TABLE}" if on_server else ""
    # Taken away and put back within the writer's transaction: no commit of a service is ever without it.
    connection.execute(f"DROP TRIGGER {trigger_name(_TABLE, 'update')}{of}")
    chosen = f"(SELECT id {these})"
    connection.execute(f"UPDATE {_TABLE} SET hash = '{TAKEN_OUT}' WHERE id IN {chosen}")
    connection.execute((server_trigger if on_server else trigger)(_TABLE, "update"))
    return count


def is_taken_out(record: str, names: Sequence[str], values: Sequence[Any]) -> bool:
    """Whether a record is a PIN without its hash, which has no longer the hash of its link."""
    if record != _TABLE:
        return False
    found = dict(zip(names, values, strict=True))
    return _said(found["kind"]) == PIN.encode() and _said(found["hash"]) == TAKEN_OUT.encode()


def without_pin(record: str, names: Sequence[str], values: Sequence[Any]) -> Sequence[Any]:
    """Return the values of a record as they are written into a copy."""
    if record != _TABLE or values[names.index("kind")] != PIN:
        return values
    return [TAKEN_OUT if name == "hash" else value for name, value in zip(names, values, strict=True)]


def _said(value: Any) -> bytes:
    return value.encode() if isinstance(value, str) else bytes(value)
