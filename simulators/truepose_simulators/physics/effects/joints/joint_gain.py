"""A joint that turns by a factor of what it should, as a wrong encoder or gear constant makes it."""

from dataclasses import dataclass

from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from truepose_simulators.physics.effects.site import NoDetails, Site, read_details
from truepose_simulators.physics.effects.stated import ALWAYS_S, ModelArm, Stated
from truepose_simulators.physics.effects.subject import joint_index


@dataclass(frozen=True, slots=True)
class JointGain:
    """Joint `joint` (0-based) turns by 1 + `gain` times the commanded angle from `from_s` on."""

    joint: int
    gain: float
    from_s: float

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the share of the commanded angle that is too much."""
        del loads  # a gain is geometry of the drive, not its elasticity
        angle = self.gain * conditions.joints_rad[:, self.joint] * conditions.since(self.from_s)
        return Deflection.of_joint(conditions, self.joint, angle)


def plant(change: PlantedChange, site: Site) -> JointGain:
    """Build the effect; the amplitude is the gain less one [1]."""
    read_details(NoDetails, change)
    return JointGain(joint_index(change, site.arm), change.amplitude, change.from_s)


def realise(stated: Stated, site: ModelArm) -> tuple[JointGain, ...]:
    """Build the identified gains, `gain_<joint>` [1]."""
    gains = stated.of_joints("gain", site.arm)
    return tuple(JointGain(joint, float(gain), ALWAYS_S) for joint, gain in enumerate(gains) if gain)
