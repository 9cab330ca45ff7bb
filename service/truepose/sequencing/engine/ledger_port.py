"""What a session writes down: each line counts only once it is on disk."""

from typing import Protocol

from truepose.domain.measurement.ledger import LedgerEntry


class Ledger(Protocol):
    """Append-only; what an earlier run appended comes back as the entries that the runner is built with."""

    async def append(self, entry: LedgerEntry) -> int:
        """Keep a line and return its number once it is on disk; a repeated key changes nothing.

        Raises RecordRefusedError where it cannot be kept now.
        """
        ...

    async def writable(self) -> None:
        """Return once lines are taken again, after one was refused."""
        ...
