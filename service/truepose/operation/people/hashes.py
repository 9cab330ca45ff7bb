"""Secrets as they are kept: what people choose as argon2id, what is random as SHA-256.

OWASP's password storage cheat sheet: argon2id with at least 19 MiB, two passes, one lane. A random secret of
256 bits needs no slow hash; nobody tries them all.
"""

import base64
import hashlib
import secrets
from collections.abc import Iterable
from typing import Final
from unicodedata import normalize

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from argon2.low_level import Type, hash_secret

MEMORY_KIB: Final = 19 * 1024
PASSES: Final = 2
_HASHER: Final = PasswordHasher(time_cost=PASSES, memory_cost=MEMORY_KIB, parallelism=1)
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


def badge_hash(badge: str, others: Iterable[str]) -> str:
    """Return what is kept of a badge; all badges of a service share a salt, so that one can be looked up."""
    salt = next((_salt(kept) for kept in others), None) or secrets.token_bytes(_SALT_BYTES)
    kept = hash_secret(
        _typed(badge).encode(),
        salt,
        time_cost=PASSES,
        memory_cost=MEMORY_KIB,
        parallelism=1,
        hash_len=_HASH_BYTES,
        type=Type.ID,
    )
    return kept.decode()


def _salt(kept: str) -> bytes:
    text = kept.split("$")[-2]
    return base64.b64decode(text + "=" * (-len(text) % 4))


def _typed(secret: str) -> str:
    """Return a secret as every keyboard would send it."""
    return normalize("NFKC", secret)
