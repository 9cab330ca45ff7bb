"""Waves of a joint's own angle: eccentric gears and encoders, and the cycle of a strain-wave gear."""

from dataclasses import dataclass
from math import atan2, hypot, pi, radians

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect


@dataclass(frozen=True, slots=True)
class HarmonicDetails:
    """Which wave: the angle that the joint is off by is amplitude * sin(order * q + phase)."""

    order: float = 2.0  # periods per turn of the joint; a strain-wave gear has 2 per turn of its generator
    phase_deg: float | None = None  # absent: drawn


@dataclass(frozen=True, slots=True)
class JointHarmonic:
    """One wave of one joint."""

    joint: int  # 0-based
    amplitude_rad: float
    order: float
    phase_rad: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the wave at the commanded angle."""
        del loads  # the wave is cut into the teeth
        wave = np.sin(self.order * conditions.joints_rad[:, self.joint] + self.phase_rad)
        return effect.Deflection.of_joint(
            conditions, self.joint, self.amplitude_rad * wave * conditions.since(self.from_s)
        )


def plant(change: effect.PlantedChange, site: effect.Site) -> JointHarmonic:
    """Build the effect; the amplitude is half of peak to peak [deg]."""
    details = effect.read_details(HarmonicDetails, change)
    joint = effect.joint_index(change, site.arm)
    highest = 2.0 * site.arm.gear_ratio[joint]
    if not 0.0 < details.order <= highest:
        raise ScenarioError(
            f'effect {change.name}: key "order" of {change.subject} must be above 0 and at most {highest:g},'
            f" twice the gear ratio, not {details.order:g}"
        )
    drawn_rad = float(site.rng().uniform(-pi, pi))
    phase_rad = drawn_rad if details.phase_deg is None else radians(details.phase_deg)
    return JointHarmonic(joint, radians(change.amplitude), details.order, phase_rad, change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[JointHarmonic, ...]:
    """Build the identified waves, `wave_<joint>_<order>_sin` and `.._cos` [rad].

    The angle about z of the joint's frame is sin * sin(order * t) + cos * cos(order * t), t what the joint
    turns by about that z; a joint that counts backwards sees its cosines with the other sign.
    """
    parts: dict[tuple[str, str], dict[str, float]] = {}
    form = "wave_<joint>_<order>_sin or _cos"
    for (joint, order, part), value in stated.matching(r"wave_([0-9]+)_([0-9.e+]+)_(sin|cos)", form):
        parts.setdefault((joint, order), {})[part] = value
    return tuple(
        _wave(stated.index(joint, site.arm.n_joints, "joint"), float(order), part, site)
        for (joint, order), part in parts.items()
    )


def _wave(joint: int, order: float, part: dict[str, float], site: effect.ModelArm) -> JointHarmonic:
    sine, cosine = part.get("sin", 0.0), site.rows[joint].sign * part.get("cos", 0.0)
    return JointHarmonic(joint, hypot(sine, cosine), order, atan2(cosine, sine), effect.ALWAYS_S)
