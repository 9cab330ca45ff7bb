"""What a session owes its ledger: halts that hold and are not on record yet, and the next prompt.

A halt must not wait for the disk. One that the ledger refuses holds all the same, in memory, and is kept
under the key of who asked for it as soon as lines are taken again.
"""

from collections.abc import Awaitable, Callable
from typing import Any, Protocol

from truepose.domain.errors import RecordRefusedError
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.engine.acts import Act
from truepose.sequencing.engine.halting.halts import Halts
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.errors import SequencingError


class Waits(Protocol):
    """Brings a session to where it waits; the caller holds `changing`."""

    async def settle(self) -> None:
        """Put what comes next on record."""
        ...

    async def hold(self, reason: str) -> None:
        """Have the session wait for a person."""
        ...


class PendingHalts:
    """Brings a session to where it waits again after lines were refused."""

    def __init__(
        self,
        logbook: Logbook[Any],
        halts: Halts,
        act: Callable[[Act], Awaitable[object]],
        waits: Waits,
    ) -> None:
        self._logbook = logbook
        self._halts = halts
        self._act = act
        self._waits = waits
        self.owed: Act | None = None

    @property
    def due(self) -> bool:
        """Whether anything waits for the ledger, so that nothing may move."""
        return self.owed is not None or self._logbook.trouble is not None

    def owe(self, act: Act) -> None:
        """Have a halt hold that was refused; where nothing could move it was not done."""
        if self._logbook.state in {SessionState.RUNNING, SessionState.PAUSING}:
            self.owed = act
        else:
            self._halts.wish = None

    async def follow(self) -> None:
        """Keep what is owed and put the next prompt whenever lines are taken again."""
        book = self._logbook
        while True:
            if self.owed is None:
                await book.refused.wait()
            await book.accepted()
            await self._pay()
            await book.keep(self._waits.settle)

    async def _pay(self) -> None:
        while self.owed is not None:
            try:
                await self._act(self.owed)
            except RecordRefusedError:
                await self._logbook.accepted()
                continue
            except SequencingError:  # the session is elsewhere by now; it waits for a person all the same
                self._halts.wish = None
                await self._logbook.keep(lambda: self._waits.hold("A halt was asked for."))
            if not self._halts.moving and self._logbook.state is SessionState.ABORTING:
                await self._logbook.keep(self._end)  # the second line of an end
            self.owed = None
        self._logbook.tell()

    async def _end(self) -> None:
        await self._halts.take_effect()
