"""Gearbox springs: softer (or stiffer) than the plant's own, or the whole springs of an identified model.

Where no mass is known, a model holds products of a compliance and a first moment of mass (x or y of a frame):
the joint turns by the product times the torque of a unit moment there.
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray, apply


@dataclass(frozen=True, slots=True)
class ExtraSpring:
    """A second spring in series with the gearbox of joint `joint` (0-based)."""

    joint: int
    compliance_rad_per_n_mm: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the wind-up of this spring."""
        wound = self.compliance_rad_per_n_mm * loads.torque_n_mm[:, self.joint]
        return effect.Deflection.of_joint(conditions, self.joint, wound * conditions.since(self.from_s))


def plant(change: effect.PlantedChange, site: effect.Site) -> ExtraSpring:
    """Build the effect; the amplitude is the compliance [rad/(N mm)] that comes on top."""
    effect.read_details(effect.NoDetails, change)
    return ExtraSpring(effect.joint_index(change, site.arm), change.amplitude, change.from_s)


@dataclass(frozen=True, slots=True)
class SpringMoment:
    """A spring times a first moment of mass that winds it up."""

    joint: int  # 0-based, that turns
    carrier: int  # 1-based body that carries the moment
    axis: FloatArray  # (3,) direction of the moment, zero configuration
    product_rad_s2_per_m: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the wind-up at the configuration as it truly is."""
        if loads.bodies is None:
            return effect.Deflection()
        moment = apply(loads.bodies.placements[:, self.carrier, :3, :3], self.axis)
        torque = np.cross(moment, np.array(loads.gravity_m_s2))
        about = np.sum(torque * loads.bodies.axis_directions[:, self.joint], axis=1)
        return effect.Deflection.of_joint(conditions, self.joint, self.product_rad_s2_per_m * about)


_FORM = "c_<joint> or c_<joint>*mx_<frame>, my_<frame>"
_NAME = r"c_([0-9]+)(?:\*m([xy])_([0-9]+))?"


def springs(stated: effect.IdentifiedEffect, n_joints: int) -> FloatArray:
    """Return identified compliances `c_<joint>` [rad/(N mm)], shape (J,); `realise` builds the products."""
    compliance = np.zeros(n_joints)
    for (joint, axis, _), value in stated.matching(_NAME, _FORM):
        if axis is None:
            compliance[stated.index(joint, n_joints, "joint")] = value
    return compliance


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[SpringMoment, ...]:
    """Build the identified products `c_<joint>*mx_<frame>` [rad s2/m]; the springs alone are the plant's."""
    return tuple(
        _moment(stated, site, (joint, axis, frame), value)
        for (joint, axis, frame), value in stated.matching(_NAME, _FORM)
        if axis is not None
    )


def _moment(
    stated: effect.IdentifiedEffect, site: effect.ModelArm, name: tuple[str, str, str], product: float
) -> SpringMoment:
    joint, axis, frame = name
    carrier = stated.index(frame, site.arm.n_joints, "joint")
    direction = site.frames[carrier, :3, "xy".index(axis)]
    return SpringMoment(stated.index(joint, site.arm.n_joints, "joint"), carrier + 1, direction, product)
