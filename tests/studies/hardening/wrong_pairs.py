"""Wrong connections of the ballbar: which are stored without a question, which right ones are questioned.

`python -m tests.studies.hardening.wrong_pairs --out DIR [--runs N] [--seed N] [--poses 6 8 10 24]
[--scenarios ...]` has robots measured as the service plans it. At every pose before the pre-calibration one
leg is read of another pair (single; that pair comes later), one of a pair that was read (repeated), and two
change places (exchanged), each once on its own; the same at the aimed poses after it. Whole sessions of an
operator who errs are those of `erring_operator`.
"""

import sys
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from tests.studies.hardening.wrong_pairs_cell import KIT, TrueRobot, in_range
from tests.studies.hardening.wrong_pairs_session import (
    HARM_MM,
    EarlyPose,
    ForeseenPose,
    Reading,
    Site,
)
from tests.studies.running import leave, study_parser
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.ballbar.plan import ballbar_plan
from truepose.storage.records import SessionSetup
from truepose.validation.early_connection_check import refuted_stops

SCENARIOS = ("irb120-tilted", "lrmate-tilted", "irb120-everyday", "lrmate-everyday")
POSES = (6, 8, 10, 24, 64)
_KINDS = ("single", "repeated", "exchanged")
_DRAWS = 360


@cache
def plan_of(cell_name, poses, draws=_DRAWS):
    """The plan that the service makes; it knows the nominal robot only, so all robots of a kind share it."""
    return ballbar_plan(simulated_cell(cell_name, 0), poses=poses, draws=draws)


def site_of(scenario, poses, seed, draws=_DRAWS):
    """A robot with its plan."""
    cell_name = scenario.replace("everyday", "tilted")
    plan = plan_of(cell_name, poses, draws)
    setup = SessionSetup(replace(simulated_cell(cell_name, 0), ballbar=KIT))
    return Site(setup, plan, TrueRobot(scenario, seed, plan), np.random.default_rng([seed, 1]))


def slips_of(site):
    """Make every kind of slip once at every pose, before and after the pre-calibration."""
    counts = Counter()
    poses = [pose for placement in site.plan.placements for pose in placement.poses]
    early = poses[: site.plan.precalibrate_after]
    accounts, kept, before = site.accounts(), {}, []
    for pose in early:
        judge = EarlyPose(accounts, site.beforehand, pose)
        before.append(accounts)
        kept[pose.config] = _read(site, pose, judge, {}, counts, "before")
        accounts = judge.after(kept[pose.config])
    for number, pose in enumerate(early):
        for kind, slips in _slips(site, pose):
            judge = EarlyPose(before[number], site.beforehand, pose)
            read = _slipped(site, pose, judge, slips, counts, "before", kind)
            if read is not None and not _found_later(site, judge.after(read), early, number, kept):
                _count_silent(site, pose, slips, counts, "before", kind)
    _after(site, kept, poses, counts)
    return counts


def _after(site, kept, poses, counts):
    known = {config: readings for config, readings in kept.items() if readings}
    found = site.precalibrated(known, {pose.config: pose for pose in poses})
    forecasts = {forecast.config: forecast for forecast in found.forecasts}
    for pose in found.poses:
        judge = ForeseenPose(forecasts[pose.config], pose)
        _read(site, pose, judge, {}, counts, "after")
        for kind, slips in _slips(site, pose):
            if _slipped(site, pose, judge, slips, counts, "after", kind) is not None:
                _count_silent(site, pose, slips, counts, "after", kind)


def _slips(site, pose):
    legs = [leg for leg in pose.legs if in_range(site.robot.stop(pose)[leg])]
    if len(legs) < 2:
        return
    first, second = sorted(site.rng.choice(len(legs), 2, replace=False).tolist())
    a, b = legs[first], legs[second]
    yield from zip(_KINDS, ({a: b}, {b: a}, {a: b, b: a}), strict=True)


def _read(site, pose, judge, slips, counts, phase):
    """Read a pose whatever is said to it, and count questions at right readings where there is no slip."""
    true, kept = site.robot.stop(pose), {}
    for leg in pose.legs:
        pair = slips.get(leg, leg)
        if in_range(true[leg]) and in_range(true[pair]):
            length_mm = site.gauge.read(true[pair])
            doubt = judge.judge(leg, length_mm, kept)
            kept[leg] = Reading(length_mm, pair, true[pair] - true[leg], asked=False)
            if not slips:
                counts[phase, "right"] += 1
                counts[phase, "questioned"] += doubt is not None
            elif doubt is not None:
                counts["last"] += 1
    return kept


def _slipped(site, pose, judge, slips, counts, phase, kind):
    """Make a slip; returns the readings where nobody was asked anything, None where somebody was."""
    counts["last"] = 0
    kept = _read(site, pose, judge, slips, counts, phase)
    asked = counts.pop("last")
    counts[phase, kind] += 1
    counts[phase, f"{kind}, asked at its pose"] += asked > 0
    return None if asked else kept


def _found_later(site, accounts, early, number, kept):
    """Whether the poses that follow, read as asked, speak against the pose with the slip."""
    stop = len(accounts.stops) - 1
    for pose in early[number + 1 :]:
        accounts = EarlyPose(accounts, site.beforehand, pose).after(kept[pose.config])
    return stop in refuted_stops(accounts)


def _count_silent(site, pose, slips, counts, phase, kind):
    true = site.robot.stop(pose)
    counts[phase, f"{kind}, silent"] += 1
    off_mm = max(abs(true[asked] - true[pair]) for asked, pair in slips.items())
    counts[phase, f"{kind}, harmful"] += off_mm > HARM_MM


def study(scenarios=SCENARIOS, poses=POSES, runs=2, seed=1, draws=_DRAWS):
    """Return counts by scenario and number of poses."""
    found = {}
    for scenario in scenarios:
        for n in poses:
            slips = Counter()
            for robot in range(seed, seed + runs):
                slips += slips_of(site_of(scenario, n, robot, draws))
            found[f"{scenario}, {n} poses"] = _named(slips)
    return found


def _named(counts):
    return {" ".join(key): int(count) for key, count in sorted(counts.items())}


def table(found):
    """Return the shares as text."""
    lines = []
    for name, slips in found.items():
        lines.append(name)
        for phase in ("before", "after"):
            lines += [f"  {phase}: {kind} {_share(slips, phase, kind)}" for kind in _KINDS]
            questioned, right = (slips.get(f"{phase} {what}", 0) for what in ("questioned", "right"))
            lines.append(f"  {phase}: right ones questioned {questioned} of {right}")
    return "\n".join(lines)


def _share(counts, phase, kind):
    made = counts.get(f"{phase} {kind}", 0)
    asked, silent, harmful = (
        counts.get(f"{phase} {kind}, {what}", 0) for what in ("asked at its pose", "silent", "harmful")
    )
    return f"{made}: asked about {asked}, never {silent}, of these off by more than {HARM_MM:g} mm {harmful}"


def main():
    parser = study_parser(__doc__, out=Path, runs=2, seed=1)
    parser.add_argument("--poses", type=int, nargs="+", default=POSES)
    parser.add_argument("--scenarios", nargs="+", default=SCENARIOS)
    options = parser.parse_args()
    found = study(options.scenarios, options.poses, options.runs, options.seed)
    leave(options.out, "wrong_pairs", found)
    sys.stdout.write(f"{table(found)}\n")


if __name__ == "__main__":
    main()
