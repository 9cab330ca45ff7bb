"""Whether what a server acknowledges survives its loss of power."""

from collections.abc import Mapping
from typing import Any, Final

from truepose.storage.errors import StorageUnavailableError

_ASKED: Final = (
    "SELECT name, setting FROM pg_settings WHERE name IN ('fsync', 'full_page_writes', 'data_checksums')"
)


def settings_of(connection: Any) -> dict[str, str]:
    """Return how a server keeps what it acknowledges."""
    return dict(connection.execute(_ASKED).fetchall())


def require_durable(where: str, settings: Mapping[str, str], *, accepted: bool) -> None:
    """Raise StorageUnavailableError for a server that loses acknowledged records, unless that is accepted."""
    if settings.get("fsync") == "off" and not accepted:
        raise StorageUnavailableError(
            f"The server of {where} runs with fsync = off: a loss of power takes records that were "
            "acknowledged. Set fsync = on there; for trials alone, add ?fsync=off to the URL."
        )


def doubts(settings: Mapping[str, str]) -> tuple[str, ...]:
    """Return a sentence for each thing by which a server may lose or not notice something."""
    return tuple(sentence for name, sentence in _DOUBTS.items() if settings.get(name) == "off")


_DOUBTS: Final = {
    "fsync": "The server runs with fsync = off: a loss of power takes records that were acknowledged.",
    "full_page_writes": (
        "The server runs with full_page_writes = off: only a file system that never tears a page survives a "
        "loss of power with it."
    ),
    "data_checksums": (
        "The server keeps no checksums of its pages; a wrong bit shows when every record is verified."
    ),
}
