"""Random ballbar sessions with an operator who errs at every step and a cell that changes.

    python -m tests.studies.hardening.erring_operator --sessions 1000 --out out/erring-operator

For each of a few simulated robots one session is walked rightly, and copies of database and cell are kept on
the way. Each random session takes up one of these copies and goes on with an operator who errs: wrong pairs,
the bar left on or put on the calibrator, confirmations too early, a second tablet, reloads, wrong answers;
and with a cell whose limits, serial numbers, cables and service change. Counted from outside: motions with
the bar attached, unconfirmed or outside the limits; acknowledged lines that are lost; wrong lengths kept
without a question, before and after the pre-calibration.
"""

import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from tests.studies.hardening.erring_operator.study import ROBOTS, Robot, Wanted, study
from tests.studies.hardening.erring_operator.tally import report
from tests.studies.running import study_parser


def main(arguments: Sequence[str] | None = None, robots: Sequence[Robot] = ROBOTS) -> int:
    """Run from the command line; exit status 1 where something moved that must not, or was lost."""
    parser = study_parser(__doc__, **{item.name: item.default for item in fields(Wanted)})
    parser.add_argument("--out", type=Path, help="folder for erring_operator.json")
    given = vars(parser.parse_args(arguments))
    out = given.pop("out")
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        tally = study(Wanted(**given), robots, Path(folder))
    text = json.dumps(report(tally), indent=1) + "\n"
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        (out / "erring_operator.json").write_text(text, encoding="utf-8")
    sys.stdout.write(text)
    return 0 if tally.passed else 1


if __name__ == "__main__":
    sys.exit(main())
