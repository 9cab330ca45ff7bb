"""What a session owes its ledger: halts that hold and are not on record yet, and the next prompt.

A halt must not wait for the disk. One that the ledger refuses holds all the same, in memory, and is kept
under the key of who asked for it as soon as lines are taken again.
"""

from collections.abc import Awaitable, Callable

from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar.acts import Act
from truepose.sequencing.ballbar.transitions import Floor
from truepose.sequencing.errors import SequencingError


class Arrears:
    """Brings a session to where it waits again after lines were refused."""

    def __init__(
        self,
        floor: Floor,
        act: Callable[[Act], Awaitable[object]],
        end_motion: Callable[[], Awaitable[None]],
    ) -> None:
        self._floor = floor
        self._act = act
        self._end_motion = end_motion
        self._owed: Act | None = None

    @property
    def due(self) -> bool:
        """Whether anything waits for the ledger, so that nothing may move."""
        return self._owed is not None or self._floor.book.trouble is not None

    def owe(self, act: Act) -> None:
        """Have a halt hold that was refused; where nothing could move it was not done."""
        if self._floor.now.state in {SessionState.RUNNING, SessionState.PAUSING}:
            self._owed = act
        else:
            self._floor.motion.wish = None

    async def follow(self) -> None:
        """Keep what is owed and put the next prompt whenever lines are taken again."""
        book = self._floor.book
        while True:
            if self._owed is None:
                await book.refused.wait()
            await book.accepted()
            await self._pay()
            await self._floor.keep(self._floor.settle)

    async def _pay(self) -> None:
        while self._owed is not None:
            try:
                await self._act(self._owed)
            except RecordRefusedError:
                await self._floor.book.accepted()
                continue
            except SequencingError:  # the session is elsewhere by now; it waits for a person all the same
                self._floor.motion.wish = None
                await self._floor.keep(lambda: self._floor.hold("A halt was asked for."))
            if not self._floor.motion.moving and self._floor.now.state is SessionState.ABORTING:
                await self._floor.keep(self._end_motion)  # the second line of an end
            self._owed = None
        self._floor.book.tell()
