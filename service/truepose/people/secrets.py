"""Secrets as they are kept: passwords and PINs as argon2id, what is random as SHA-256.

OWASP's password storage cheat sheet: argon2id with at least 19 MiB, two passes, one lane. A random secret of
256 bits needs no slow hash; nobody tries them all.

A PIN is mixed with a secret of the installation; before its hash stands which one that was:
`1f0c99ab$argon2id$...`.
"""

import asyncio
import base64
import hashlib
import hmac
import secrets
from collections.abc import Callable, Iterable
from typing import Final, TypeVar
from unicodedata import normalize

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import Type, hash_secret

from truepose.storage.secret_files import Pepper, name_of

T = TypeVar("T")
MEMORY_KIB: Final = 19 * 1024
PASSES: Final = 2
_HASHER: Final = PasswordHasher(time_cost=PASSES, memory_cost=MEMORY_KIB, parallelism=1)
_AT_ONCE: Final = 2  # each takes 19 MiB and a processor
_HASH_BYTES: Final = 32
_SALT_BYTES: Final = 16
_RANDOM_BYTES: Final = 32
# Of no secret that could be found: whoever is unknown is looked at for as long as everybody else. Salt and
# hash are zeros: to work out a true one would take a thirtieth of a second of every start.
NOBODYS: Final = f"$argon2id$v=19$m={MEMORY_KIB},t={PASSES},p=1${'A' * 22}${'A' * 43}"


def new_secret() -> str:
    """Return a random secret that can stand in an address, a header or a cookie."""
    return secrets.token_urlsafe(_RANDOM_BYTES)


def fingerprint(secret: str) -> str:
    """Return what is kept of a random secret."""
    return hashlib.sha256(secret.encode(errors="surrogateescape")).hexdigest()


def chosen_hash(secret: str) -> str:
    """Return what is kept of a secret that somebody chose; takes a thirtieth of a second."""
    return _HASHER.hash(_typed(secret))


def matches(kept: str, secret: str) -> bool:
    """Whether a secret is the one that was chosen."""
    try:
        return _HASHER.verify(kept, _typed(secret))
    except (VerificationError, InvalidHashError):
        return False


class Badges:
    """Works out what is kept of badges; all of a service share a salt, so that one can be looked up."""

    def __init__(self, kept: Iterable[str]) -> None:
        """Go on with the salt of what is kept; where nothing is, with a new one."""
        self._salt = next(map(_salt, kept), None) or secrets.token_bytes(_SALT_BYTES)

    def hashed(self, badge: str) -> str:
        """Return what is kept of a badge; takes a thirtieth of a second."""
        kept = hash_secret(
            _typed(badge).encode(),
            self._salt,
            time_cost=PASSES,
            memory_cost=MEMORY_KIB,
            parallelism=1,
            hash_len=_HASH_BYTES,
            type=Type.ID,
        )
        return kept.decode()


def _salt(kept: str) -> bytes:
    # Kept as `$argon2id$v=19$m=...,t=...,p=...$SALT$HASH`, in base64 without its padding.
    text = kept.split("$")[-2]
    return base64.b64decode(text + "=" * (-len(text) % 4))


def _typed(secret: str) -> str:
    """Return a secret as every keyboard would send it."""
    return normalize("NFKC", secret)


class SlowHashes:
    """Has slow hashes worked out beside the event loop, a few at once."""

    def __init__(self) -> None:
        self._places = asyncio.Semaphore(_AT_ONCE)

    async def of(self, work: Callable[..., T], *given: object) -> T:
        """Return what `work` returns, once it is its turn."""
        async with self._places:
            return await asyncio.to_thread(work, *given)


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
        hashed = (kept or NOBODYS).partition("$")[2]
        key = self._pepper.key()
        right = matches(f"${hashed}", pin if key is None else _mixed(key, pin))
        return right and kept is not None and self.counts(kept)

    def counts(self, kept: str) -> bool:
        """Whether a PIN can be right here: its hash is there, and so is the secret that it was mixed with."""
        key = self._pepper.key()
        return key is not None and kept.startswith(f"{name_of(key)}$")


def _mixed(key: bytes, pin: str) -> str:
    # A PIN has so few digits that its slow hash alone gives it away to whoever reads the database (commit
    # 78613b0d).
    return hmac.new(key, normalize("NFKC", pin).encode(), hashlib.sha256).hexdigest()
