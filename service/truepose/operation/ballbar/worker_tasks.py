"""What is computed for a ballbar session, in a worker process: its plan, its pre-calibration."""

from typing import Final, cast

from truepose.analysis.workers.process import Perform
from truepose.analysis.workers.tasks import BallbarPlanTask, PrecalibrateTask
from truepose.analysis.workers.turns import Turns
from truepose.domain.measurement.ballbar import BallbarPlan, PreCalibration
from truepose.domain.measurement.ledger import LedgerEntry
from truepose.operation.ballbar.counting import counting
from truepose.operation.ballbar.plans import BallbarWish, kit_of
from truepose.storage.records import SessionSetup

_WAITING: Final = 3  # of plans; each holds one of the sixteen places that the door has
_PATIENCE_S: Final = 300.0  # a plan takes a minute at most


class BallbarWork:
    """Sends tasks to a worker; what it says of its progress is nobody's here.

    One plan is made at a time. A pre-calibration waits for none: a person stands in the cell.
    """

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        self._plans = Turns("plans", at_once=1, waiting=_WAITING, patience_s=_PATIENCE_S)

    async def choose(self, setup: SessionSetup, wish: BallbarWish) -> BallbarPlan:
        """Return the plan of a session; cancelling it ends the worker. Raises TrueposeError, BusyError."""
        async with self._plans.taken():
            return cast(BallbarPlan, await self._perform(plan_task(setup, wish), _nobody))

    def precalibrator(self, setup: SessionSetup) -> "WorkerPreCalibrator":
        """Return who pre-calibrates a session."""
        return WorkerPreCalibrator(setup, self._perform)


def plan_task(setup: SessionSetup, wish: BallbarWish) -> BallbarPlanTask:
    """Return the choice of poses and placements as a worker is asked for it."""
    return BallbarPlanTask(setup, wish.frames, wish.placements, wish.poses, wish.seed, wish.sphere)


class WorkerPreCalibrator:
    """Pre-calibrates one session; what `truepose.sequencing.ballbar` asks for."""

    def __init__(self, setup: SessionSetup, perform: Perform) -> None:
        self._setup = setup
        self._perform = perform

    async def precalibrate(self, plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
        """Return where to aim from now on, and which lengths to expect there; raises TrueposeError."""
        counts = counting(plan, kit_of(self._setup), entries)
        task = PrecalibrateTask(self._setup, plan, counts)
        return cast(PreCalibration, await self._perform(task, _nobody))


async def _nobody(fraction: float, doing: str) -> None:
    """Take progress that nobody follows."""
