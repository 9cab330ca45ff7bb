"""Sessions of an arm that is off its table, as they are before a pre-calibration."""

from dataclasses import dataclass, replace

import numpy as np

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm
from tests.helpers.ballbar.nominal_poses import reachable
from tests.helpers.ballbar.true_session import READING_U_MM, TrueArm
from truepose.domain.ballbar import BallbarPlan, PlannedPlacement
from truepose.domain.cell import BallbarKit
from truepose.planning.ballbar.length_forecast import SessionForecast
from truepose.planning.ballbar.poses import setups
from truepose.validation.early_connection_check import Accounts, begin, judge_early

KIT = BallbarKit()
_SIDES = ((1, 2), (1, 3), (2, 3))


def plan_of(cell, poses=12):
    """Return a plan without ways: poses that are as different as their order among all of them is."""
    fixture = fixture_before_the_arm()
    every = reachable(cell, fixture)
    chosen = np.linspace(0, len(every) - 1, poses).astype(int)
    found = tuple(replace(every[row], config=config) for config, row in enumerate(chosen, start=1))
    cups = tuple(tuple(float(x) for x in cup) for cup in fixture.cups_mm)
    return BallbarPlan((PlannedPlacement(1, fixture.frame, cups, setups(cell, fixture), found),))


@dataclass
class EarlySession:
    """An arm, what was read of it, and what is asked about."""

    arm: TrueArm
    plan: BallbarPlan
    beforehand: SessionForecast
    rng: np.random.Generator
    accounts: Accounts

    @staticmethod
    def of(seed, poses=12):
        arm = TrueArm.drawn(ballbar_cell(), seed, angle_rad=0.7e-3, length_mm=0.12)
        plan = plan_of(arm.cell, poses)
        beforehand = SessionForecast(arm.cell, plan, KIT)
        session = EarlySession(
            arm, plan, beforehand, np.random.default_rng(seed), begin(beforehand.kinds(), KIT)
        )
        session._read_sides()
        return session

    def true_mm(self, pose, leg):
        return self.arm.length(self.plan.placements[0], pose.joints_rad, leg)

    def pose(self, pose, slips=None):
        """Read all legs of a pose, some of other pairs; returns what is asked, by leg."""
        slips = slips or {}
        stop = self.beforehand.poses(1, np.array([pose.joints_rad]))[0]
        self.accounts = self.accounts.at(stop)
        asked = {}
        for leg in pose.legs:
            length_mm = self._noisy(self.true_mm(pose, slips.get(leg, leg)))
            self.accounts = self.accounts.read(leg, length_mm)
            asked[leg] = judge_early(self.accounts, complete=leg == pose.legs[-1])
        return asked

    def _read_sides(self):
        cups = self.arm.cups(self.plan.placements[0])
        self.accounts = self.accounts.at(self.beforehand.sides(1))
        for a, b in _SIDES:
            length_mm = self._noisy(float(np.linalg.norm(cups[a - 1] - cups[b - 1])))
            self.accounts = self.accounts.read((a, b), length_mm)

    def _noisy(self, true_mm):
        return true_mm + READING_U_MM * self.rng.standard_normal()
