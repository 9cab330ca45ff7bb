"""Where commands of the same machine find the service that has a database open, and what opens it to them.

Who can read this file can read the database beside it as well: it opens no more than that does. It is
there as long as the service runs, and its secret is another one at each start.
"""

import contextlib
import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Final

_OWNER_ALONE: Final = 0o600


@dataclass(frozen=True, slots=True)
class ReachedService:
    """How the service of a database is reached from its own machine."""

    url: str
    secret: str
    certificate: str | None = None  # file that it shows, where it speaks TLS


@contextlib.contextmanager
def told_beside(database: Path, service: ReachedService) -> Iterator[None]:
    """Say beside a database how its service is reached, for as long as the context lasts."""
    place = _place(database)
    place.unlink(missing_ok=True)  # of a service that was killed; its owner may have been another
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
