"""Joints that are off by curves: dozens of lines over the joint's own angle, as worn gears have.

Their orders lie between a few and many periods per turn and need not be whole; no single line is large.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import FloatArray

_ANGLES = 20_001  # of one turn at which the curve is looked at: hundreds a period of the highest order


@dataclass(frozen=True, slots=True)
class CurveSizes:
    """Which joints are off by curves, and by how much."""

    joints: tuple[int, ...] = (1, 2, 3)
    lines: int = 25  # of each joint
    orders: tuple[float, float] = (5.0, 60.0)  # periods per turn, from and to
    share_not_whole: float = 0.2  # of the orders
    peak_to_peak_deg: float = 0.07  # of each joint's curve over a turn

    def __post_init__(self) -> None:
        lowest, highest = self.orders
        if not 0.0 < lowest <= highest:
            raise ScenarioError(f'key "orders" must be above 0 and rise, not {lowest:g} and {highest:g}')
        if self.lines < 1:
            raise ScenarioError(f'key "lines" must be 1 or more, not {self.lines}')
        if not 0.0 <= self.share_not_whole <= 1.0:
            raise ScenarioError(f'key "share_not_whole" must be from 0 to 1, not {self.share_not_whole:g}')


def draw_curves(sizes: CurveSizes, arm: Arm, rng: np.random.Generator) -> tuple[PlantedChange, ...]:
    """Draw the lines of every joint; raises ScenarioError where the arm has no such joint."""
    if not all(1 <= joint <= arm.n_joints for joint in sizes.joints):
        raise ScenarioError(f'key "joints" must be from 1 to {arm.n_joints}')
    return tuple(line for joint in sizes.joints for line in _lines(sizes, joint, rng))


def _lines(sizes: CurveSizes, joint: int, rng: np.random.Generator) -> Iterator[PlantedChange]:
    orders = rng.uniform(*sizes.orders, sizes.lines)
    whole = rng.uniform(size=sizes.lines) >= sizes.share_not_whole
    orders[whole] = np.round(orders[whole])
    heights = rng.uniform(0.3, 1.0, sizes.lines)
    phases_deg = rng.uniform(-180.0, 180.0, sizes.lines)
    scale = sizes.peak_to_peak_deg / _peak_to_peak(orders, heights, np.radians(phases_deg))
    for order, height, phase_deg in zip(orders, heights * scale, phases_deg, strict=True):
        details = {"order": float(order), "phase_deg": float(phase_deg)}
        yield PlantedChange("joint_harmonics", f"joint {joint}", float(height), details=details)


def _peak_to_peak(orders: FloatArray, heights: FloatArray, phases_rad: FloatArray) -> float:
    turn = np.linspace(-np.pi, np.pi, _ANGLES)
    curve = sum(
        height * np.sin(order * turn + phase)
        for order, height, phase in zip(orders, heights, phases_rad, strict=True)
    )
    return float(np.ptp(curve))
