"""A ballbar session measured on an arm that is off its table by tenths of a degree and of a millimetre."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from tests.helpers.ballbar.sessions import make_length
from truepose.analysis.campaigns.ballbar import RestPose, ValidCupSetup, ValidLength, ValidReadings, ValidSide
from truepose.domain.ballbar import ArrivalTaken, BallbarPlan
from truepose.kinematics.chain import forward, nominal_values

READING_U_MM = 0.0016  # of a reading with its zero, as the kit states them


@dataclass(frozen=True)
class TrueArm:
    """The arm as it is, and where its cups came to be clamped."""

    cell: object  # truepose.planning.ballbar.bodies.BallbarCell
    errors: np.ndarray  # (4, J): alpha [rad], a [mm], theta [rad], d [mm]

    @staticmethod
    def drawn(cell, seed, angle_rad=0.002, length_mm=0.3):
        rng = np.random.default_rng(seed)
        scale = np.array([[angle_rad], [length_mm], [angle_rad], [length_mm]])
        errors = scale * rng.standard_normal((4, cell.robot.n_joints))
        errors[:, 0] = 0.0  # the base is the world
        return TrueArm(cell, errors)

    def nests(self, joints_rad):
        """Nests in the world, (n, 3, 3)."""
        values = nominal_values(self.cell.robot, np.atleast_2d(joints_rad))
        alpha, a, theta, d = self.errors
        values = replace(
            values,
            alpha_rad=values.alpha_rad + alpha,
            a_mm=values.a_mm + a,
            theta_rad=values.theta_rad + theta,
            d_mm=values.d_mm + d,
        )
        chain = forward(values, np.eye(3), np.zeros(3))
        return np.stack([chain.points(nest) for nest in self.cell.nests_mm], axis=1)

    def cups(self, placement):
        """Base cups, (K, 3): where nest 1 was held."""
        return self.nests([setup.joints_rad for setup in placement.setups])[:, 0]

    def length(self, placement, joints_rad, leg):
        """Return the true length of a leg."""
        base, tool = leg
        return float(np.linalg.norm(self.nests(joints_rad)[0, tool - 1] - self.cups(placement)[base - 1]))


def measured_session(arm, plan: BallbarPlan, configs, *, placements=(1,), seed=0, range_mm=None):
    """What counts after these configurations were measured, with the noise that the kit states."""
    rng = np.random.default_rng(seed)
    legs, sides, setups = [], [], []

    def taken(true_mm, initialisation):
        noise_mm = READING_U_MM * rng.standard_normal()
        return make_length(
            true_mm + noise_mm, initialisation=initialisation, standard_uncertainty_mm=READING_U_MM
        )

    nests = arm.cell.nests_mm
    for a, b in combinations((1, 2, 3), 2):
        sides.append(ValidSide(0, (a, b), taken(np.linalg.norm(nests[b - 1] - nests[a - 1]), 1)))
    for placement in plan.placements:
        if placement.number not in placements:
            continue
        cups = arm.cups(placement)
        setups += [
            ValidCupSetup(placement.number, s.base_point, arrival(s.joints_rad)) for s in placement.setups
        ]
        for a, b in combinations(range(1, len(cups) + 1), 2):
            length = np.linalg.norm(cups[b - 1] - cups[a - 1])
            sides.append(ValidSide(placement.number, (a, b), taken(length, 2)))
        for pose in placement.poses:
            if pose.config not in configs:
                continue
            for leg in pose.legs:
                true_mm = arm.length(placement, pose.joints_rad, leg)
                if range_mm is None or abs(true_mm - 300.0) <= range_mm:
                    length = taken(true_mm, 2 + pose.config)
                    at = arrival(pose.joints_rad)
                    legs.append(ValidLength(placement.number, pose.config, 1, leg, length, at, pose.config))
    standing = RestPose(legs[-1].placement, legs[-1].arrival.commanded_rad) if legs else None
    return ValidReadings(tuple(legs), tuple(sides), tuple(setups), standing=standing)


def arrival(joints_rad):
    return ArrivalTaken(tuple(joints_rad), tuple(joints_rad), (1,) * len(joints_rad), 50.0)
