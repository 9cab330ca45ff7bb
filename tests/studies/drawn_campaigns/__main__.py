"""Asks everything about very many drawn campaigns, and counts answers, refusals and failures.

`python -m tests.studies.drawn_campaigns --n 10000 --out out/drawn` writes `drawn.json`; a failure is printed
with its seed, and `--first SEED --n 1` asks about that campaign again. Status 1 where something failed.
"""

import argparse
import json
import sys
from collections import Counter
from pathlib import Path

from tests.studies.drawn_campaigns.asking import asked_about


def main() -> int:
    """Ask about the campaigns of so many seeds."""
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
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
    (out / "drawn.json").write_text(json.dumps({"endings": endings, "failures": failures}, indent=1))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--n", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/drawn"))
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
