"""Robots for unit tests: one with parallel axes, one with seven axes, signs and a sloping link."""

import numpy as np

from truepose.domain.robot import JointRange, JointRow, LinkMass, Robot


def _rows(*table):
    return tuple(
        JointRow(np.deg2rad(alpha), a, np.deg2rad(theta), d, sign) for alpha, a, theta, d, sign in table
    )


IRB_120 = Robot(
    name="ABB IRB 120",
    joints=_rows(
        (0, 0, 0, 290, 1),
        (-90, 0, -90, 0, 1),
        (0, 270, 0, 0, 1),
        (-90, 70, 0, 302, 1),
        (90, 0, 0, 0, 1),
        (-90, 0, 180, 72, 1),
    ),
    masses=(
        LinkMass(2, 4.2, (140.0, 0.0, 0.0)),
        LinkMass(4, 5.0, (0.0, 0.0, -193.6)),
        LinkMass(6, 2.7, (50.0, 25.0, 100.0)),
    ),
    typical_compliances_rad_per_n_mm=(2e-8, 3.2e-8, 1.3e-7, 6.05e-7, 4.19e-7, 6.47e-7),
    repeatability_mm=0.0035,
    calibration_ranges=tuple(
        JointRange(np.deg2rad(low), np.deg2rad(high))
        for low, high in ((-90, 90), (0, 90), (-80, 50), (-150, 150), (-90, 90), (-180, 180))
    ),
)

SEVEN_AXES = Robot(
    name="seven axes",
    joints=_rows(
        (0, 0, 0, 340, 1),
        (-90, 0, 10, 0, -1),
        (90, 20, 0, 400, 1),
        (90, 0, 0, 0, 1),
        (-88, 0, 0, 400, -1),
        (-90, 5, 0, 0, 1),
        (90, 0, 30, 126, 1),
    ),
)
