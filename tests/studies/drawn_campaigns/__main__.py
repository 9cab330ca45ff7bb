"""Asks everything about very many drawn campaigns, and counts answers, refusals and failures.

`python -m tests.studies.drawn_campaigns --n 10000 --out out/drawn` writes `drawn.json`; a failure is printed
with its seed, and `--first SEED --n 1` asks about that campaign again. Status 1 where something failed.
"""

import json
import sys
from collections import Counter
from pathlib import Path

from tests.studies.drawn_campaigns.asking import asked_about
from tests.studies.running import leave, study_options


def main() -> int:
    """Ask about the campaigns of so many seeds."""
    options = study_options(__doc__, n=100, first=0, out=Path("out/drawn"))
    endings, failures = Counter[str](), list[dict[str, object]]()
    for seed in range(options.first, options.first + options.n):
        drawn, asked = asked_about(seed)
        endings.update(f"{one.question}: {one.ending}" for one in asked)
        failed = [one for one in asked if one.ending == "failure"]
        endings["campaigns with a failure"] += bool(failed)
        for one in failed:
            told = {"seed": seed, "kind": drawn.kind, "oddities": drawn.oddities, "effects": drawn.effects}
            failures.append(told | {"question": one.question, "told": one.told})
            sys.stdout.write(f"{json.dumps(told)} {one.question}\n{one.told}\n")
        endings["campaigns"] += 1
        if options.n > 1 and endings["campaigns"] % 50 == 0:
            _write(options.out, endings, failures)
    _write(options.out, endings, failures)
    sys.stdout.write("".join(f"{name:28} {count}\n" for name, count in sorted(endings.items())))
    return 1 if failures else 0


def _write(out: Path, endings: Counter[str], failures: list[dict[str, object]]) -> None:
    leave(out, "drawn", {"endings": endings, "failures": failures})


if __name__ == "__main__":
    sys.exit(main())
