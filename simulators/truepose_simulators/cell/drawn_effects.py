"""Effects that every robot has at once, drawn from the seed: small ones of every kind, and joint curves.

Their orders lie between a few and many periods per turn and need not be whole; no single line is large.

A plant whose links and springs alone are off would be too good: identified with everything that the usual
models know, it leaves its repeatability. A measured one leaves ten times as much (A. Nubiola, thesis, ETS
Montreal 2014, chapter 2: 0.13-0.18 mm); the sizes here add up to that.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm, CarriedMass
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.effects.backlash import MEASURED_GAPS_DEG
from truepose_simulators.physics.effects.link_bending import Beam, sag_mm
from truepose_simulators.physics.effects.rigid_change import unit_or_drawn
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


_WAVES_DEG = (0.004, 0.003, 0.001, 0.002, 0.004)  # of orders 1, 2, 3, the gear ratio and twice that
_WAVE_LEVERS = (1.0, 1.0, 1.2, 2.0, 1.6, 2.0)  # the smaller the gear, the coarser; joints 1 to 6
_WAVE_FACTOR = (0.5, 1.5)
_GAIN = 3e-5
_COUPLING = 1e-4
_COUPLED = ((6, 5), (6, 4), (5, 4))  # joint moved, joint that moves it
_MASS_SHARE = 0.10  # at most
_CENTRE_MM = 6.0
_SOFTER_UNLOADED = 0.3
_BEAMS = (Beam(2, 8e-12), Beam(3, 6e-12))  # 1/EI [1/(N mm2)]
_BASE_COMPLIANCE_RAD_PER_N_MM = 1e-9
_NEST_MM = 0.02
_DRIFT_MM_PER_H = 0.006
_DRIFT_RAD_PER_H = 4e-6
_EXPANSION_PER_K = 18e-6
_WARM_UP_K = 1.0
_WARM_UP_S = 2400.0


@dataclass(frozen=True, slots=True)
class EverydaySizes:
    """How far an everyday robot is from a clean one."""

    factor: float = 1.35  # on every size below
    over_time: bool = True  # False: neither drift nor warm-up

    def __post_init__(self) -> None:
        if not 0.0 < self.factor <= 10.0:
            raise ScenarioError(f'key "factor" must be above 0 and at most 10, not {self.factor:g}')


def draw_everyday(
    sizes: EverydaySizes, arm: Arm, tool: CarriedMass | None, n_nests: int, rng: np.random.Generator
) -> tuple[PlantedChange, ...]:
    """Draw the effects; the same generator state gives the same robot at any factor, only better or worse."""
    k = sizes.factor
    changes = [
        *_waves(arm, k, rng),
        *_gears(arm, k, rng),
        *_masses(arm, tool, k, rng),
        *_soft_parts(arm, tool, k),
        *_nests(n_nests, k, rng),
    ]
    # Drawn last, so that the robot without them is otherwise the same one.
    slow = [*_slow_changes(k, rng)]
    return tuple(changes + slow if sizes.over_time else changes)


def _waves(arm: Arm, k: float, rng: np.random.Generator) -> Iterator[PlantedChange]:
    for joint, (ratio, lever) in enumerate(zip(arm.gear_ratio, _WAVE_LEVERS, strict=True), start=1):
        for order, size_deg in zip((1.0, 2.0, 3.0, ratio, 2.0 * ratio), _WAVES_DEG, strict=True):
            amplitude = k * size_deg * lever * rng.uniform(*_WAVE_FACTOR)
            details = {"order": order, "phase_deg": float(rng.uniform(-180.0, 180.0))}
            yield PlantedChange("joint_harmonics", f"joint {joint}", amplitude, details=details)


def _gears(arm: Arm, k: float, rng: np.random.Generator) -> Iterator[PlantedChange]:
    for joint in range(1, arm.n_joints + 1):
        yield PlantedChange("joint_gain", f"joint {joint}", k * _GAIN * float(rng.standard_normal()))
    for moved, source in _COUPLED:
        share = k * _COUPLING * float(rng.standard_normal())
        yield PlantedChange("joint_coupling", f"joint {moved}", share, details={"source": f"joint {source}"})


def _masses(
    arm: Arm, tool: CarriedMass | None, k: float, rng: np.random.Generator
) -> Iterator[PlantedChange]:
    for stated in (*arm.masses, *([] if tool is None else [tool])):
        extra_kg = k * _MASS_SHARE * stated.mass_kg * float(rng.uniform(-1.0, 1.0))
        shift_mm = (k * _CENTRE_MM * unit_or_drawn(None, rng)).tolist()
        name, subject = ("payload", "tool") if stated is tool else ("link_mass", f"link {stated.joint}")
        yield PlantedChange(name, subject, extra_kg, details={"centre_shift_mm": shift_mm})


def _soft_parts(arm: Arm, tool: CarriedMass | None, k: float) -> Iterator[PlantedChange]:
    yield PlantedChange("compliance_nonlinear", "joints", k * _SOFTER_UNLOADED)
    for beam in _BEAMS:
        yield PlantedChange("link_bending", f"link {beam.link}", k * sag_mm(arm, tool, (beam,)))
    yield PlantedChange("base_compliance", "base", k * _BASE_COMPLIANCE_RAD_PER_N_MM)
    yield PlantedChange("backlash", "joints", k * max(MEASURED_GAPS_DEG))


def _nests(n_nests: int, k: float, rng: np.random.Generator) -> Iterator[PlantedChange]:
    for nest in range(1, n_nests + 1):
        offset_mm = k * _NEST_MM * rng.standard_normal(3)
        details = {"direction": offset_mm.tolist()}
        yield PlantedChange("nest_offset", f"nest {nest}", float(np.linalg.norm(offset_mm)), details=details)


def _slow_changes(k: float, rng: np.random.Generator) -> Iterator[PlantedChange]:
    drift = {
        "rotation_rad_per_h": k * _DRIFT_RAD_PER_H,
        "direction": unit_or_drawn(None, rng).tolist(),
        "axis": unit_or_drawn(None, rng).tolist(),
    }
    yield PlantedChange("base_drift", "base", k * _DRIFT_MM_PER_H, details=drift)
    warm_up = {"warm_up_k": k * _WARM_UP_K, "time_constant_s": _WARM_UP_S}
    yield PlantedChange("thermal_growth", "links", _EXPANSION_PER_K, details=warm_up)
