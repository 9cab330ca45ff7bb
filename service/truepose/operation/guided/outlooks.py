"""What sessions promise, asked of a worker once for as many readings, however many tablets look."""

from typing import Final, cast

from truepose.analysis.campaigns.assembly import MeasuredSession
from truepose.analysis.workers.outlook import Outlook, OutlookTask
from truepose.analysis.workers.process import Perform
from truepose.analysis.workers.turns import Turns

FEWEST: Final = 11  # configurations; fewer identify nothing that a promise could rest on
_WAITING: Final = 3
_PATIENCE_S: Final = 60.0


class Outlooks:
    """Keeps the newest one of each session."""

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        self._turns = Turns("outlooks", at_once=1, waiting=_WAITING, patience_s=_PATIENCE_S)
        self._known: dict[int, tuple[tuple[int, int], Outlook]] = {}

    async def of(self, session: MeasuredSession, left: int) -> Outlook | None:
        """Return what a session promises, None before enough is measured; raises TrueposeError, BusyError."""
        if len(session.points) < FEWEST:
            return None
        amounts = len(session.points), left
        async with self._turns.taken():
            known = self._known.get(session.id)
            if known is not None and known[0] == amounts:
                return known[1]
            found = cast(Outlook, await self._perform(OutlookTask(session, left), _nobody))
            self._known[session.id] = amounts, found
            return found


async def _nobody(fraction: float, doing: str) -> None:
    """Take progress that nobody follows."""
