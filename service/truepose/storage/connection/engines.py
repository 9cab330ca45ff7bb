"""Which engine an address asks for."""

from truepose.storage.connection.holding import Alone, Holding
from truepose.storage.connection.sqlite.holding import SQLiteFile
from truepose.storage.integrity.condition import Condition


def holding(url: str, condition: Condition, alone: Alone) -> Holding:
    """Return the database of a URL, not opened yet; raises DatabaseAddressError."""
    return SQLiteFile(url, condition, alone)
