"""Whether the accuracy that a plan promises is attained: plan, measure the simulated cell, identify, compare.

`python -m tests.studies.promise --out out/promise` takes a minute on one core. The mean of one calibration
scatters by some 15 % (tracker) and 30 % (ballbar, one placement) about what is promised; the standard error
of the mean over all cells is given beside it.
"""

import argparse
import sys
from pathlib import Path
from typing import Final

from tests.studies.promise.ballbar import ballbar_promises
from tests.studies.promise.kept import Tally, tally
from tests.studies.promise.tracker import resumed_promise, tracker_promise
from tests.studies.running import leave, study_parser

_SCENARIO: Final = "irb120-tilted"
_EVERYDAY: Final = "irb120-everyday"  # the parameters do not express all of it


def main() -> int:
    """Measure, print and write what was promised and attained."""
    options = _options()
    seeds = range(options.first, options.first + options.seeds)
    found = [
        tally("tracker", [tracker_promise(options.scenario, seed, options.n) for seed in seeds]),
        tally("ballbar", ballbar_promises(options.scenario, seeds, options.n)),
        tally("gone on with", [resumed_promise(_EVERYDAY, seed) for seed in seeds]),
    ]
    for one in found:
        sys.stdout.write(_told(one))
    leave(options.out, "promise", found)
    return 0


def _options() -> argparse.Namespace:
    parser = study_parser(__doc__, out=Path, scenario=_SCENARIO, seeds=20, first=(1, "the first seed"))
    parser.add_argument("--n", type=int, help="configurations (default: the knee of the curve)")
    return parser.parse_args()


def _told(one: Tally) -> str:
    return (
        f"{one.kind}: promised {1e3 * one.promised_mm:.2f} um, attained {1e3 * one.attained_mm:.2f} um "
        f"({one.off_percent:+.1f} +-{one.spread_percent:.1f} %); {one.inside} of {one.cells} inside the "
        f"stated 90 %; worst {1e3 * one.worst_promised_mm:.1f} against {1e3 * one.worst_attained_mm:.1f} um\n"
    )


if __name__ == "__main__":
    sys.exit(main())
