"""Times of one weighted solution with covariance, printed as JSON: positions -> median milliseconds."""

import json
import sys
import time
from typing import Final

import numpy as np

from tests.studies.bench.ours import campaign
from truepose.identification.fit.robust import fit
from truepose.identification.observations.poses import position_block
from truepose.identification.problem.build import automatic_effects, build

_SIZES: Final = (50, 1000, 10000)
_RUNS: Final = 9


def main() -> None:
    """Print the times."""
    sys.stdout.write(json.dumps({n: _median_ms(n) for n in _SIZES}) + "\n")


def _median_ms(n: int) -> float:
    measured = campaign(n)
    problem = build(measured, automatic_effects(measured))
    block = position_block(measured.calibration, measured.scatter_mm) if measured.calibration else None
    blocks = (block,) if block else ()
    taken = []
    for _ in range(_RUNS):
        start = time.perf_counter()
        fit(problem.structure, blocks, problem.structure.prior_means)
        taken.append(1e3 * (time.perf_counter() - start))
    return float(np.median(taken))


if __name__ == "__main__":
    main()
