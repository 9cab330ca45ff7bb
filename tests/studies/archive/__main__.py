"""An archive of simulated campaigns on Dask: one worker against two, and the cost of each.

`python -m tests.studies.archive --out out/archive --campaigns 1000 --readings 200` identifies and diagnoses
every campaign on one worker and on two, part by part in turn, so that whatever else the computer does weighs
on both. The bits of all results are compared; that a killed worker loses none is told by `plant_kills`.
Printed and in archive.json: the ratio of the times, what a campaign costs beside its computing, and the load
of the computer. What is in the folder already is not recorded again.
"""

import contextlib
import os
import sys
from pathlib import Path
from typing import Final

from tests.studies.archive.compared import compared
from tests.studies.archive.recorded import recorded_archive
from tests.studies.running import leave, study_options
from truepose.analysis.parallel.dask_pool import of_this_computer

_SCENARIOS: Final = ("irb120-clean", "irb120-tilted", "irb120-everyday")


def main() -> int:
    """Record, compute, compare; status 1 where a figure is missed."""
    options = study_options(
        __doc__,
        out=Path,
        campaigns=30,
        readings=200,
        scenarios=(",".join(_SCENARIOS), "in turn (default: %(default)s)"),
        part=(10, "campaigns between two turns"),
    )
    before = os.getloadavg()
    campaigns = recorded_archive(
        options.out / "campaigns", options.campaigns, options.readings, options.scenarios.split(",")
    )
    with contextlib.ExitStack() as held:
        one, two = (held.enter_context(of_this_computer(count)) for count in (1, 2))
        found = compared(campaigns, one, two, options.part, _tell)
    load = {"load_before": before, "load_after": os.getloadavg(), "processors": os.cpu_count()}
    document = {"asked": {**vars(options), "out": ""}, **found.figures, **load}
    leave(options.out, "archive", document)
    sys.stdout.write(found.told() + f"load {before[0]:.1f} to {os.getloadavg()[0]:.1f}\n")
    return 0 if found.reached else 1


def _tell(text: str) -> None:
    sys.stderr.write(f"{text}\n")


if __name__ == "__main__":
    sys.exit(main())
