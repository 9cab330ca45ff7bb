"""Backlash: a joint stops short of where it is sent, by half of the gap, whichever way it comes."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray

# How the gaps of a small arm compare, joints 1 to 6; A. Nubiola, thesis, ETS Montreal 2014, table 2.3.
MEASURED_GAPS_DEG = (0.004, 0.002, 0.004, 0.037, 0.017, 0.037)


@dataclass(frozen=True, slots=True)
class Backlash:
    """Gaps of the joints; a direction of 0 (unknown) stands in the middle."""

    gap_rad: FloatArray  # (J,) full gaps
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return half a gap against the direction of approach."""
        del loads
        angles = -0.5 * self.gap_rad * np.sign(conditions.direction)
        return effect.Deflection(angles_rad=angles * conditions.since(self.from_s)[:, np.newaxis])


def plant(change: effect.PlantedChange, site: effect.Site) -> Backlash:
    """Build the effect; the amplitude is the full gap [deg], of `joints` the largest of the gaps."""
    effect.read_details(effect.NoDetails, change)
    joints = effect.joint_indices(change, site.arm)
    share = np.zeros(site.arm.n_joints)
    share[list(joints)] = 1.0 if len(joints) == 1 else _measured_shares(change, site.arm.n_joints)
    return Backlash(np.radians(change.amplitude * share), change.from_s)


def _measured_shares(change: effect.PlantedChange, n_joints: int) -> FloatArray:
    measured = np.array(MEASURED_GAPS_DEG)
    if n_joints != len(measured):
        raise ScenarioError(
            f'effect {change.name}: "joints" has the proportions of an arm of {len(measured)} joints; this'
            f' one has {n_joints}; plant "joint 1" and the others one by one'
        )
    shares: FloatArray = measured / measured.max()
    return shares


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[Backlash, ...]:
    """Build the identified gaps, `gap_<joint>` [rad]."""
    return (Backlash(stated.of_joints("gap", site.arm), effect.ALWAYS_S),)
