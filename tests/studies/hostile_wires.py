"""Hostile input to every driver, and faults of its link: what a night asks of the contract suite.

`python -m tests.studies.hostile_wires --out DIR [--runs N] [--faults N] [--seed N] [--driver NAME]` asks each
driver so many times over a line that spoils an answer (`truepose_drivers.contract.hostile`), and lets so many
faults befall its link (`truepose_drivers.contract.link_faults`). Time is simulated, so nobody waits.
"""

import argparse
import json
import sys
from dataclasses import asdict
from pathlib import Path

from tests.contract.devices.every import BENCHES
from truepose_drivers.contract import hostile, link_faults

_COLUMNS = (
    "inputs", "right", "no_value", "refused", "wrong_betrayable", "wrong_unseen", "foreign", "hung",
    "out_of_step", "cpu_s",
)  # fmt: skip


def table(tallies):
    """Return the tallies of hostile inputs as lines of a table."""
    head = " ".join(f"{name:>16s}" for name in ("driver", *_COLUMNS))
    lines = [
        " ".join(f"{value!s:>16s}" for value in (tally.driver, *(getattr(tally, c) for c in _COLUMNS)))
        for tally in tallies
    ]
    return [head, *lines]


def main():
    named = {bench.plugin.name: bench for bench in BENCHES}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument(
        "--runs", type=int, default=hostile.QUICK_INPUTS, help="hostile inputs to each driver"
    )
    parser.add_argument("--faults", type=int, default=link_faults.FAULTS_EACH, help="faults of each link")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--driver", choices=named, action="append", help="only this one; may be repeated")
    options = parser.parse_args()
    benches = [named[name] for name in options.driver or named]
    tallies = [hostile.tally(bench, options.runs, options.seed) for bench in benches]
    links = [link_faults.tally(bench, options.faults, options.seed) for bench in benches]
    options.out.mkdir(parents=True, exist_ok=True)
    document = {
        "runs": options.runs,
        "seed": options.seed,
        "drivers": [asdict(tally) for tally in tallies],
        "links": [asdict(tally) for tally in links],
    }
    (options.out / "hostile_wires.json").write_text(json.dumps(document, indent=1))
    lines = [*table(tallies), "", *map(link_faults.line, links)]
    sys.stdout.writelines(f"{line}\n" for line in lines)


if __name__ == "__main__":
    main()
