"""The ledger of one session under way, as its runner asks for it."""

from truepose.domain.ledger import LedgerEntry
from truepose.storage.measurement.ledger import LedgerRepository


class SessionLedger:
    """Appends to the disk and keeps the number of the newest entry at hand."""

    def __init__(self, session_id: int, ledger: LedgerRepository, newest: int | None) -> None:
        self._session_id = session_id
        self._ledger = ledger
        self.newest = newest  # number of the newest entry; None before the first

    async def append(self, entry: LedgerEntry) -> int:
        """Keep an entry and return its number once it is on disk."""
        number = await self._ledger.append(self._session_id, entry)
        self.newest = max(number, self.newest or 0)
        return number

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._ledger.writable()
