"""A joint that turns by a factor of what it should, as a wrong encoder or gear constant makes it."""

from dataclasses import dataclass

from truepose_simulators.physics.effects import effect


@dataclass(frozen=True, slots=True)
class JointGain:
    """Joint `joint` (0-based) turns by 1 + `gain` times the commanded angle from `from_s` on."""

    joint: int
    gain: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the share of the commanded angle that is too much."""
        del loads  # a gain is geometry of the drive, not its elasticity
        angle = self.gain * conditions.joints_rad[:, self.joint] * conditions.since(self.from_s)
        return effect.Deflection.of_joint(conditions, self.joint, angle)


def plant(change: effect.PlantedChange, site: effect.Site) -> JointGain:
    """Build the effect; the amplitude is the gain less one [1]."""
    effect.read_details(effect.NoDetails, change)
    return JointGain(effect.joint_index(change, site.arm), change.amplitude, change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[JointGain, ...]:
    """Build the identified gains, `gain_<joint>` [1]."""
    gains = stated.of_joints("gain", site.arm)
    return tuple(JointGain(joint, float(gain), effect.ALWAYS_S) for joint, gain in enumerate(gains) if gain)
