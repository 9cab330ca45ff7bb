"""The ledger of one session under way, as its runner asks for it."""

from collections.abc import Sequence

from truepose.domain.measurement.ledger import LedgerEntry
from truepose.storage.measurement.ledger import LedgerRepository
from truepose.storage.records import LedgerRecord


class SessionLedger:
    """Appends to the disk and keeps the number of the newest entry at hand; `kept` is of earlier runs."""

    def __init__(self, session_id: int, ledger: LedgerRepository, kept: Sequence[LedgerRecord]) -> None:
        self._session_id = session_id
        self._ledger = ledger
        self.earlier = tuple(record.entry for record in kept)
        self.newest = kept[-1].id if kept else None  # number of the newest entry; None before the first

    async def append(self, entry: LedgerEntry) -> int:
        """Keep an entry and return its number once it is on disk."""
        number = await self._ledger.append(self._session_id, entry)
        self.newest = max(number, self.newest or 0)
        return number

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._ledger.writable()
