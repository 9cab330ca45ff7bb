"""PINs as they are kept: argon2id of what the PIN and the installation's own secret give together.

Before it stands which secret that was: `1f0c99ab$argon2id$...`. A PIN of an older version
has none and counts until it is used; then it is kept in the new way.
"""

import hashlib
import hmac
from unicodedata import normalize

from truepose.operation.people.hashes import NOBODYS, chosen_hash, matches
from truepose.storage.people.pepper import Pepper, name_of


class Pins:
    """Keeps PINs, and compares them."""

    def __init__(self, pepper: Pepper) -> None:
        self._pepper = pepper

    def kept(self, pin: str) -> str:
        """Return what is kept of a PIN; takes a thirtieth of a second. Raises StorageUnavailableError."""
        key = self._pepper.made()
        return name_of(key) + chosen_hash(_mixed(key, pin))

    def match(self, kept: str | None, pin: str) -> bool:
        """Whether a PIN is the one that was chosen; of none that counts it takes as long."""
        name, _, hashed = (kept or NOBODYS).partition("$")
        key = self._pepper.key()
        right = matches(f"${hashed}", _mixed(key, pin) if name and key is not None else pin)
        return right and kept is not None and self.counts(kept)

    def counts(self, kept: str) -> bool:
        """Whether a PIN can be right here: its hash is there, and so is the secret that it was mixed with."""
        key = self._pepper.key()
        return kept.startswith("$") or (key is not None and kept.startswith(f"{name_of(key)}$"))

    @staticmethod
    def is_old(kept: str) -> bool:
        """Whether no secret was mixed in."""
        return kept.startswith("$")


def _mixed(key: bytes, pin: str) -> str:
    return hmac.new(key, normalize("NFKC", pin).encode(), hashlib.sha256).hexdigest()
