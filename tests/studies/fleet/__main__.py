"""Fleets of forty robots over five months: what is named, what is not, and what a new robot gains.

`python -m tests.studies.fleet --fleets 20 --out out/fleet` takes some 30 s of one core a fleet. Identified
fleets are kept in the folder, so that a study that was interrupted goes on.
"""

import argparse
import pickle
import sys
from pathlib import Path

import numpy as np

from tests.studies.fleet.held import Held, held
from tests.studies.fleet.newcomers import NewRobot, Promises, newcomers, promised
from tests.studies.fleet.simulated import FleetTruth, draw_fleet, identified_fleet
from tests.studies.running import leave, study_options
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.changes import account_of

_WITHOUT_FROM = 100  # seeds of fleets in which nothing ages


def main() -> int:
    """Measure, print and write."""
    options = study_options(
        __doc__,
        out=Path,
        fleets=(20, "in which nothing ages"),
        ageing=(10, "in which three robots and a tracker do"),
        first=(1, "seed of the first fleet of either kind"),
        robots=40,
        configurations=(40, "of each campaign"),
        new=(10, "new robots of each ageing fleet"),
    )
    options.out.mkdir(parents=True, exist_ok=True)
    fleets: list[Held] = []
    new: list[NewRobot] = []
    promises: list[Promises] = []
    for seed in range(options.first, options.first + options.ageing):
        one, robots, said = _studied(options, seed, ageing=3)
        fleets.append(one)
        new += robots
        promises += said
        _written(options.out, fleets, new, promises)
    first = _WITHOUT_FROM + options.first
    for seed in range(first, first + options.fleets):
        fleets.append(_studied(options, seed, ageing=0)[0])
        _written(options.out, fleets, new, promises)
    sys.stdout.write(_told(fleets, new, promises))
    return 0


def _studied(
    options: argparse.Namespace, seed: int, ageing: int
) -> tuple[Held, list[NewRobot], list[Promises]]:
    truth, measured = _identified(options, seed, ageing)
    account = account_of(fleet_of(measured))
    found = held(truth, account)
    sys.stderr.write(f"fleet {seed}: {found.right} right, {found.missed} missed, {found.false} false\n")
    if not ageing or not options.new:
        return found, [], []
    said = promised(account, truth)
    return found, newcomers(account, truth, said, options.new), [said.figures]


def _identified(
    options: argparse.Namespace, seed: int, ageing: int
) -> tuple[FleetTruth, list[FleetCampaign]]:
    kept = options.out / f"fleet-{seed}-{options.robots}-{options.configurations}-{ageing}.pickle"
    if kept.is_file():
        return pickle.loads(kept.read_bytes())
    truth = draw_fleet(seed, options.robots, ageing=ageing, drifting=ageing > 0)
    measured = identified_fleet(truth, options.configurations)
    kept.write_bytes(pickle.dumps((truth, measured)))
    return truth, measured


def _written(out: Path, fleets: list[Held], new: list[NewRobot], promises: list[Promises]) -> None:
    leave(out, "fleet", {"fleets": fleets, "new_robots": new, "promises": promises})


def _told(fleets: list[Held], new: list[NewRobot], promises: list[Promises]) -> str:
    ageing, steady = ([one for one in fleets if bool(one.planted) is way] for way in (True, False))
    lines = [*_of_ageing(ageing), *_of_new(new)]
    if steady:
        lines.append(f"{len(steady)} fleets without: {sum(one.false for one in steady)} changes named")
    if promises:
        pooled, alone, check = (
            np.mean([getattr(one, key) for one in promises])
            for key in ("pooled_mm", "alone_mm", "quick_check")
        )
        lines.append(f"promised: {1e3 * pooled:.1f} and {1e3 * alone:.1f} um; quick check: {check:.1f} stops")
    return "\n".join(lines) + "\n"


def _of_ageing(fleets: list[Held]) -> list[str]:
    if not fleets:
        return []
    planted, right, alone, missed, false = (
        sum(getattr(one, key) for one in fleets) for key in ("planted", "right", "alone", "missed", "false")
    )
    covered = [ok for one in fleets for ok in one.covered]
    return [
        f"{len(fleets)} fleets with ageing: {right} of {planted} changes named rightly, {alone} without",
        f"  a rival, {missed} missed, {false} false; forecasts of 90 % held {sum(covered)} of {len(covered)}",
    ]


def _of_new(new: list[NewRobot]) -> list[str]:
    if not new:
        return []
    pooled, alone, same = (
        np.array([getattr(one, key) for one in new]) for key in ("pooled_mm", "alone_mm", "same_mm")
    )
    return [
        f"{len(new)} new robots, mean errors: {1e3 * pooled.mean():.1f} um with 15 readings and the type;",
        f"  with 50 alone {1e3 * alone.mean():.1f} um by the usual effects (better in "
        f"{100 * np.mean(pooled <= alone):.0f} %),",
        f"  {1e3 * same.mean():.1f} um by those of the fleet (better in "
        f"{100 * np.mean(pooled <= same):.0f} %)",
    ]


if __name__ == "__main__":
    sys.exit(main())
