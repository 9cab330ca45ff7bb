"""Hostile input to every driver, and faults of its link: what a night asks of the contract suite.

`python -m tests.studies.hardening.hostile_wires --out DIR [--bytes N] [--runs N] [--faults N] [--seed N]
[--driver D]` gives each codec so many hostile inputs (`codec_fuzz` of the suite; 2000000 in a night), asks
each driver so many times over a line that spoils an answer (`hostile`), and lets so many faults befall its
link (`link_faults`). Time is simulated, so nobody waits.
"""

import sys
from pathlib import Path

from tests.studies.running import leave, study_parser
from truepose_drivers.contract import codec_fuzz, hostile, link_recovery
from truepose_drivers.contract.bench import find_benches

_EVERY = "tests.contract.devices.every:BENCHES"
_OF_CODECS = ("inputs", "read", "refused", "waiting", "foreign", "cpu_s")
_COLUMNS = (
    "inputs", "right", "no_value", "refused", "wrong_betrayable", "wrong_unseen", "foreign", "hung",
    "out_of_step", "cpu_s",
)  # fmt: skip


def table(tallies, columns):
    """Return tallies as lines of a table."""
    head = " ".join(f"{name:>16s}" for name in ("driver", *columns))
    lines = [
        " ".join(f"{value!s:>16s}" for value in (tally.driver, *(getattr(tally, c) for c in columns)))
        for tally in tallies
    ]
    return [head, *lines]


def main():
    parser = study_parser(
        __doc__,
        out=Path,
        bytes=(hostile.QUICK_INPUTS, "hostile inputs to a codec"),
        runs=(hostile.QUICK_INPUTS, "answers spoiled"),
        faults=(link_recovery.FAULTS_EACH, "faults of each link"),
        seed=0,
    )
    parser.add_argument("--driver", action="append", help="only this one; may be repeated")
    options = parser.parse_args()
    benches = list(find_benches([_EVERY], options.driver).values())
    codecs = [codec_fuzz.tally(bench, options.bytes, options.seed) for bench in benches]
    tallies = [hostile.tally(bench, options.runs, options.seed) for bench in benches]
    links = [link_recovery.tally(bench, options.faults, options.seed) for bench in benches]
    lines = [*table(codecs, _OF_CODECS), "", *table(tallies, _COLUMNS), "", *map(link_recovery.line, links)]
    sys.stdout.writelines(f"{line}\n" for line in lines)
    found = {"codecs": codecs, "drivers": tallies, "links": links}
    asked = {"bytes": options.bytes, "runs": options.runs, "seed": options.seed}
    leave(options.out, "hostile_wires", asked | found)


if __name__ == "__main__":
    main()
