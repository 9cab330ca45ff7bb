"""Which engine an address asks for."""

from truepose.storage.connection.address import is_server, parsed_url
from truepose.storage.connection.holding import Alone, Holding
from truepose.storage.connection.reading import require_library
from truepose.storage.connection.sqlite.holding import SQLiteFile
from truepose.storage.integrity.condition import Condition


def holding(url: str, condition: Condition, alone: Alone) -> Holding:
    """Return the database of a URL, not opened yet; raises DatabaseAddressError."""
    if not is_server(parsed_url(url)):
        return SQLiteFile(url, condition, alone)
    require_library()
    from truepose.storage.connection.postgresql.holding import ServerDatabase

    return ServerDatabase(url, condition, alone)
