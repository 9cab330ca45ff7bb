"""Fleets unlike those that the comparison was made with: what was right, and what is said.

`python -m tests.studies.fleet.beside --out out/beside` takes some ten seconds of one core a fleet. What
campaigns tell is kept in the folder, so that a comparison that was changed is tried again at once;
`--case NAME` tries one.
"""

import pickle
import sys
from pathlib import Path

from tests.studies.fleet.beside.cases import CASES, Case, Planted
from tests.studies.fleet.beside.visits import DAYS_A_MONTH, measured
from tests.studies.running import study_parser
from truepose.exchange.cells.file import simulated_cell
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.changes import RealChange, account_of
from truepose.fleet.trials import Change


def main() -> int:
    """Measure and print."""
    parser = study_parser(__doc__, out=Path, fleets=(2, "of each case"), first=(1, "seed of the first"))
    parser.add_argument("--case", choices=sorted(CASES), action="append")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.case or CASES:
        for seed in range(options.first, options.first + options.fleets):
            _tried(options.out, name, seed)
    return 0


def _tried(out: Path, name: str, seed: int) -> None:
    case = CASES[name](seed)
    account = account_of(
        fleet_of(_identified(out, name, seed, case)), simulated_cell("irb120-clean", 1).robot
    )
    right = [one for one in account.named if any(_is_right(planted, one) for planted in case.planted)]
    found = [planted for planted in case.planted if any(_is_right(planted, one) for one in right)]
    false = len(account.named) - len(right)
    missed = len(case.planted) - len(found)
    sys.stdout.write(
        f"{name} {seed}: {len(found)} of {len(case.planted)} right, {missed} missed, {false} else"
    )
    sys.stdout.write(f"; Birge {account.birge_ratio:.2f}\n")
    for one in account.named:
        sys.stdout.write(f"    {'+' if one in right else '!'} {_said(one)}\n")
    for other in account.unlike:
        month, fits = other.day / DAYS_A_MONTH, other.resembles or "no robot"
        sys.stdout.write(
            f"    left out: {other.robot} of month {month:g}, fits {fits}, ratio {other.ratio:.0f}\n"
        )
    sys.stdout.flush()


def _identified(out: Path, name: str, seed: int, case: Case) -> list[FleetCampaign]:
    kept = out / f"{name}-{seed}.pickle"
    if not kept.is_file():
        kept.write_bytes(pickle.dumps(measured(case.robots, case.visits)))
    return pickle.loads(kept.read_bytes())


def _is_right(planted: Planted, named: RealChange) -> bool:
    change = named.change
    return (
        change.of in planted.of.split("|")
        and (change.cause.effect in planted.effects or "any" in planted.effects)
        and planted.subject in {"", change.cause.subject}
        and change.kind in planted.kinds
        and change.since == planted.month * DAYS_A_MONTH + planted.days
    )


def _said(named: RealChange) -> str:
    size = f"{1e3 * named.size_mm:.0f} +- {1e3 * named.size_u_mm:.0f} um, ratio {named.trial.ratio:.0f}"
    rivals = "".join(f"; or {_of(one.change)}" for one in named.rivals[:4])
    return f"{_of(named.change)}: {size}{rivals}"


def _of(change: Change) -> str:
    cause = change.cause
    order = f" {cause.order:g}" if cause.order else ""
    month = change.since / DAYS_A_MONTH
    return f"{change.of or 'type'} {cause.effect} {cause.subject}{order} {change.kind} from {month:g}"


if __name__ == "__main__":
    sys.exit(main())
