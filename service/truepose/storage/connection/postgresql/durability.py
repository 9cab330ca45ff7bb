"""Whether what a server acknowledges survives its loss of power."""

from collections.abc import Mapping
from typing import Any, Final

from truepose.storage.errors import ServerRefusedError

_ASKED: Final = (
    "SELECT name, setting FROM pg_settings WHERE name IN ('fsync', 'full_page_writes', 'data_checksums')"
)

# What is acknowledged can go with the power; only where the file system tears pages; wrong bits show later.
_BY_WEIGHT: Final = ("fsync", "full_page_writes", "data_checksums")


def settings_of(connection: Any) -> dict[str, str]:
    """Return how a server keeps what it acknowledges."""
    return dict(connection.execute(_ASKED).fetchall())


def require_durable(where: str, settings: Mapping[str, str], *, accepted: bool) -> None:
    """Raise ServerRefusedError for a server that loses acknowledged records, unless that is accepted."""
    if settings.get("fsync") == "off" and not accepted:
        raise ServerRefusedError(
            f"The server of {where} runs with fsync = off: a loss of power takes records that were "
            "acknowledged. Set fsync = on there; for trials alone, add ?fsync=off to the URL."
        )


def doubts(settings: Mapping[str, str]) -> tuple[str, ...]:
    """Return the settings that are off, the gravest first."""
    return tuple(name for name in _BY_WEIGHT if settings.get(name) == "off")
