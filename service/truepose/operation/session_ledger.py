"""The ledger of one ballbar session under way, as the runner asks for it."""

from truepose.domain.ballbar import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar import control
from truepose.storage.measurement.ballbar_ledger import BallbarLedger


class SessionLedger:
    """Appends to the disk and keeps the number of the newest entry at hand."""

    def __init__(self, session_id: int, ledger: BallbarLedger, newest: int | None) -> None:
        self._session_id = session_id
        self._ledger = ledger
        self.newest = newest  # number of the newest entry; None before the first

    async def append(self, entry: LedgerEntry) -> int:
        """Keep an entry, and the state that it says was entered; return its number once it is on disk."""
        number = await self._ledger.append(self._session_id, entry, _entered(entry))
        self.newest = max(number, self.newest or 0)
        return number

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._ledger.writable()


def _entered(entry: LedgerEntry) -> tuple[SessionState, str] | None:
    state = control.state_in(entry.text) if entry.kind is EntryKind.CONTROL else None
    return None if state is None else (state, control.reason_in(entry.text))
