"""A whole ballbar session at its judges: an operator who errs, answers, and reads again."""

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from tests.helpers.ballbar.sessions import make_length
from tests.studies.hardening.wrong_pairs_cell import KIT, NOMINAL_MM, RANGE_MM, Gauge, in_range
from truepose.analysis.ballbar_plans import precalibrate
from truepose.analysis.campaigns.ballbar import RestPose, ValidCupSetup, ValidLength, ValidReadings, ValidSide
from truepose.domain.ballbar import ArrivalTaken, Leg, PlannedPose, PoseForecast
from truepose.planning.ballbar.length_forecast import forecast_lengths
from truepose.validation.connection_check import judge_leg, judge_pose
from truepose.validation.early_connection_check import begin, judge_early

_NOISE = {"reading_u_mm": KIT.reading_u_mm, "zero_u_mm": KIT.zero_u_mm}
_FOLLOWS = 0.5  # having taken B for A, takes A for B
_MAINTAINS = 0.05  # says that a wrong pair is right
HARM_MM = 0.005  # a length that is off by less is off by no more than three of its uncertainties


@dataclass
class Reading:
    """A kept length."""

    length_mm: float
    pair: Leg  # that it truly is of
    off_mm: float  # against the pair that was asked for
    asked: bool = False  # a person was asked about it, and said that it is right


@dataclass
class Site:
    """What a session rests on: the robot, its plan, and what the service knows of it."""

    setup: object  # SessionSetup
    plan: object  # BallbarPlan
    robot: object  # TrueRobot
    rng: np.random.Generator
    gauge: Gauge = field(init=False)

    def __post_init__(self):
        self.gauge = Gauge(self.rng)
        self.beforehand = forecast_lengths(self.setup.cell, self.plan, KIT)
        nests = np.array([nest.centre_mm for nest in self.setup.cell.nests])
        self.sides = {(0, (a, b)): self._side(np.linalg.norm(nests[a - 1] - nests[b - 1]))
                      for a, b in ((1, 2), (2, 3), (1, 3))}  # fmt: skip
        for placement in self.plan.placements:
            for points, true_mm in self.robot.sides(placement.number).items():
                if in_range(true_mm):
                    self.sides[placement.number, points] = self._side(true_mm)

    def _side(self, true_mm):
        return self.gauge.read(float(true_mm))

    def accounts(self):
        """What the sides of the first placement say."""
        placement = self.plan.placements[0].number
        accounts = begin(self.beforehand.kinds(), KIT).at(self.beforehand.sides(placement))
        for (number, points), length_mm in self.sides.items():
            if number == placement:
                accounts = accounts.read(points, length_mm)
        return accounts

    def counting(self, kept, poses):
        """What the service would count of these readings."""
        legs = [
            ValidLength(
                pose.placement, config, 1, leg, _taken(reading.length_mm), _arrival(pose.joints_rad), config
            )
            for config, readings in kept.items()
            for pose in [poses[config]]
            for leg, reading in readings.items()
        ]
        setups = [
            ValidCupSetup(placement.number, setup.base_point, _arrival(setup.joints_rad))
            for placement in self.plan.placements
            for setup in placement.setups
        ]
        sides = [ValidSide(number, points, _taken(mm)) for (number, points), mm in self.sides.items()]
        last = poses[next(reversed(kept))]
        return ValidReadings(tuple(legs), tuple(sides), tuple(setups),
                        standing=RestPose(last.placement, last.joints_rad))  # fmt: skip

    def precalibrated(self, kept, poses):
        """The pre-calibration of the service."""
        return precalibrate(self.setup, self.plan, self.counting(kept, poses))


def _taken(length_mm):
    return make_length(length_mm, standard_uncertainty_mm=float(np.hypot(*_NOISE.values())))


def _arrival(joints_rad):
    return ArrivalTaken(tuple(joints_rad), tuple(joints_rad), (1,) * len(joints_rad), 50.0)


class EarlyPose:
    """Judges the readings of one pose by all accounts of those before."""

    def __init__(self, accounts, beforehand, pose: PlannedPose):
        stop = beforehand.poses(pose.placement, np.array([pose.joints_rad]))[0]
        self._before = accounts.at(stop)
        self._legs = pose.legs

    def judge(self, leg, length_mm, kept):
        after = self.after(kept).read(leg, length_mm)
        return judge_early(after, complete=len(kept) + 1 == len(self._legs))

    def after(self, kept):
        accounts = self._before
        for leg, reading in kept.items():
            accounts = accounts.read(leg, reading.length_mm, affirmed=reading.asked)
        return accounts


class ForeseenPose:
    """Judges the readings of one pose by what a pre-calibration foresees."""

    def __init__(self, forecast: PoseForecast, pose: PlannedPose):
        self._forecast = forecast
        self._legs = pose.legs

    def judge(self, leg, length_mm, kept):
        earlier = {other: reading.length_mm for other, reading in kept.items()}
        known = {**_NOISE, "range_mm": RANGE_MM}
        doubt = judge_leg(leg, length_mm, earlier, self._forecast, nominal_mm=NOMINAL_MM, **known)
        if doubt is not None or len(kept) + 1 < len(self._legs):
            return doubt
        found = judge_pose({**earlier, leg: length_mm}, self._forecast, **known)
        return found[0] if found else None


class Operator:
    """Connects, errs at a share of the legs, looks when asked, and now and then maintains what is wrong."""

    def __init__(self, site: Site, rate: float, counts: Counter):
        self._site, self._rate, self._counts = site, rate, counts

    def measure(self, pose, judge, phase):
        """Read all legs of a pose that are in range; returns what is kept."""
        self._true = self._site.robot.stop(pose)
        kept: dict[Leg, Reading] = {}
        todo = [leg for leg in pose.legs if in_range(self._true[leg])]
        careful: set[Leg] = set()
        follows: dict[Leg, Leg] = {}
        while todo:
            leg = todo.pop(0)
            pair = leg if leg in careful else self._connected(leg, follows)
            length_mm = self._site.gauge.read(self._true[pair])
            doubt = judge.judge(leg, length_mm, kept)
            self._counts[phase, "wrong" if pair != leg else "right"] += 1
            again = [] if doubt is None else self._asked_again(doubt, leg, pair, kept, phase)
            if leg not in again:
                off_mm = self._true[pair] - self._true[leg]
                kept[leg] = Reading(length_mm, pair, off_mm, asked=doubt is not None)
            for other in again:
                kept.pop(other, None)
                careful.add(other)
            todo = [*again, *todo]
        return kept

    def _connected(self, leg, follows):
        rng = self._site.rng
        if leg in follows:
            return follows.pop(leg)
        others = [pair for pair, mm in self._true.items() if pair != leg and in_range(mm)]
        if not others or rng.random() >= self._rate:
            return leg
        pair = others[int(rng.integers(len(others)))]
        if rng.random() < _FOLLOWS:
            follows[pair] = leg
        return pair

    def _asked_again(self, doubt, leg, pair, kept, phase):
        """Answer a question; returns the legs that are read again."""
        meant = [other for other in (doubt.asked, doubt.suspected) if other in kept and other != leg]
        if pair == leg:
            is_cause = any(kept[other].pair != other for other in meant)
            self._counts[phase, "asked for cause" if is_cause else "false alarm"] += 1
            if doubt.kind == "same_pair":
                return [other for other in meant if not kept[other].asked]
            return meant if doubt.kind == "exchanged" else []
        if self._site.rng.random() < _MAINTAINS:
            self._counts[phase, "maintained"] += 1
            return []
        self._counts[phase, "named" if doubt.suspected == pair else "asked"] += 1
        return [leg, *meant] if doubt.kind == "exchanged" else [leg]


def whole_session(site: Site, rate: float) -> Counter:
    """Walk through a session as the service leads through it, and count what became of wrong connections."""
    counts: Counter = Counter()
    operator = Operator(site, rate, counts)
    poses = {pose.config: pose for placement in site.plan.placements for pose in placement.poses}
    first = min(site.plan.precalibrate_after, len(poses))
    kept, accounts = {}, site.accounts()
    for config in [*poses][:first]:
        early = EarlyPose(accounts, site.beforehand, poses[config])
        kept[config] = operator.measure(poses[config], early, "before")
        accounts = early.after(kept[config])
    _count_kept(kept.values(), "before", "when read", counts)
    measured = {config for config in kept if kept[config]}
    while measured:
        found = site.precalibrated({c: kept[c] for c in kept if kept[c]}, poses)
        counts["all", "poses measured again"] += len(found.exchanged)
        counts["all", "... for nothing"] += sum(
            all(r.pair == leg for leg, r in kept[c].items()) for c in found.exchanged
        )
        before = [kept.pop(config) for config in found.exchanged]
        counts["all", "wrong in these"] += sum(r.pair != leg for k in before for leg, r in k.items())
        if not found.poses:
            break
        forecasts = {forecast.config: forecast for forecast in found.forecasts}
        for pose in found.poses:
            poses[pose.config] = replace(poses[pose.config], joints_rad=pose.joints_rad)
            after = ForeseenPose(forecasts[pose.config], pose)
            kept[pose.config] = operator.measure(pose, after, "after")
        if not site.plan.check_at_end:
            break
        site.plan = replace(site.plan, check_at_end=False)  # once is what is counted
    early_ones = [kept[config] for config in measured if config in kept and config <= first]
    _count_kept(early_ones, "before", "at the end", counts)
    _count_kept([kept[c] for c in kept if c > first], "after", "at the end", counts)
    return counts


def _count_kept(kept, phase, when, counts):
    for readings in kept:
        for leg, reading in readings.items():
            if reading.pair != leg and not reading.asked:
                counts[phase, f"silent {when}"] += 1
                counts[phase, f"harmful {when}"] += abs(reading.off_mm) > HARM_MM
