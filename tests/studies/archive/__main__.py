"""An archive of simulated campaigns on Dask: one worker against two, the cost of each, a worker killed.

`python -m tests.studies.archive --out out/archive --campaigns 1000 --readings 200` identifies and diagnoses
every campaign on one worker and on two, part by part in turn, so that whatever else the computer does weighs
on both. Once more two workers compute a part of it, one of which is killed in the middle. The bits of all
results are compared. Printed and in archive.json: the ratio of the times, what a campaign costs beside its
computing, and the load of the computer. What is in the folder already is not recorded again.
"""

import argparse
import contextlib
import json
import os
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Final

from tests.studies.archive.compared import compared
from tests.studies.archive.killed import killed_in_the_middle
from tests.studies.archive.recorded import recorded_archive
from truepose.analysis.parallel.dask_pool import of_this_computer

_SCENARIOS: Final = ("irb120-clean", "irb120-tilted", "irb120-everyday")


def main() -> int:
    """Record, compute, compare; status 1 where a figure is missed."""
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    before = os.getloadavg()
    campaigns = recorded_archive(
        options.out / "campaigns", options.campaigns, options.readings, options.scenarios.split(",")
    )
    with contextlib.ExitStack() as held:
        one, two = (held.enter_context(of_this_computer(count)) for count in (1, 2))
        found = compared(campaigns, one, two, options.part, _tell)
    killed = killed_in_the_middle(campaigns[: options.killed], found.bits, _tell)
    load = {"load_before": before, "load_after": os.getloadavg(), "processors": os.cpu_count()}
    document = {"asked": {**vars(options), "out": ""}, **found.figures, "killed": asdict(killed), **load}
    (options.out / "archive.json").write_text(json.dumps(document, indent=1))
    sys.stdout.write(found.told() + killed.told() + f"load {before[0]:.1f} to {os.getloadavg()[0]:.1f}\n")
    return 0 if found.reached and killed.reached else 1


def _tell(text: str) -> None:
    sys.stderr.write(f"{text}\n")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--campaigns", type=int, default=30)
    parser.add_argument("--readings", type=int, default=200)
    parser.add_argument("--scenarios", default=",".join(_SCENARIOS), help="in turn (default: %(default)s)")
    parser.add_argument("--part", type=int, default=10, help="campaigns between two turns")
    parser.add_argument("--killed", type=int, default=12, help="campaigns of the run with a killed worker")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
