"""What a night tries, in its order."""

from truepose.demo.night.cells.ballbar_cells import BallbarCell
from truepose.demo.night.cells.calibrated_cells import calibrated_cells
from truepose.demo.night.cells.loop_cells import loop_cells
from truepose.demo.night.check import NightCase
from truepose.demo.night.faults.bad_lines import bad_lines
from truepose.demo.night.faults.crashes import KilledService
from truepose.demo.night.faults.faulty_sessions import FaultySession
from truepose.demo.night.faults.planted_causes import planted_causes
from truepose.demo.night.upgrades import upgraded_databases

# Accuracy is compared between nights: only the program may change in between, not the robot.
_SAME_CELLS = 0


def night_cases(seed: int, benches: tuple[str, ...] = ()) -> list[NightCase]:
    """Return the cases of a night; `seed` draws what is to be another every night.

    `benches` are those of drivers beside the installed ones (`MODULE:NAME`); raises UnknownCaseError.
    """
    return [
        *calibrated_cells(_SAME_CELLS),
        *(BallbarCell(scenario, _SAME_CELLS) for scenario in ("irb120-tilted", "lrmate-tilted")),
        *loop_cells(_SAME_CELLS),
        *planted_causes(seed),
        *(FaultySession(scenario, seed) for scenario in ("irb120-clean", "lrmate-fanuc", "ur10-clean")),
        KilledService(seed),
        *upgraded_databases(),
        *bad_lines(seed, benches),
    ]
