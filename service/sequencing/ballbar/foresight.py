"""Who identifies with what is there halfway: heavy work, done elsewhere."""

from typing import Protocol

from service.domain.ballbar import BallbarPlan, LedgerEntry, PreCalibration


class Foresight(Protocol):
    """Computes where to aim and which lengths to expect there."""

    async def precalibrate(self, plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
        """Identify with what these lines say was measured; raises TrueposeError where that is impossible."""
        ...
