"""Who identifies with what is there halfway: heavy work, done elsewhere."""

from typing import Protocol

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.errors import TrueposeError
from truepose.domain.measurement.ballbar import BallbarPlan, PreCalibration
from truepose.domain.measurement.ledger import LedgerEntry
from truepose.sequencing.ballbar.plan.dry_run import check_pose


class PreCalibrator(Protocol):
    """Computes where to aim and which lengths to expect there."""

    async def precalibrate(self, plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
        """Identify with what these lines say was measured; raises TrueposeError where that is impossible."""
        ...


async def precalibrated(
    precalibrator: PreCalibrator, plan: BallbarPlan, kit: BallbarKit, entries: tuple[LedgerEntry, ...]
) -> PreCalibration | str:
    """Return what was found, or the sentence that says why nothing was."""
    try:
        found = await precalibrator.precalibrate(plan, entries)
        for pose in found.poses:
            check_pose(pose, kit)
    except TrueposeError as error:
        return str(error)
    except Exception as error:  # whatever it is, the readings are safe and a person decides
        return f"The program failed ({type(error).__name__}): {error}"
    return found
