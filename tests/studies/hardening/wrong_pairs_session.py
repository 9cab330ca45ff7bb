"""What a ballbar session rests on, and its judges of connections before and after the pre-calibration."""

from dataclasses import dataclass, field

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
