"""A joint that another one drags along, as the shafts of a wrist run through each other."""

from dataclasses import dataclass

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect


@dataclass(frozen=True, slots=True)
class CouplingDetails:
    """Who drags."""

    source: str | None = None  # such as "joint 5"; absent: the joint before, of joint 1 the one after


@dataclass(frozen=True, slots=True)
class JointCoupling:
    """Joint `moved` turns by `share` of the angle of joint `source` (both 0-based)."""

    moved: int
    source: int
    share: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the angle that comes over from the other joint."""
        del loads
        angle = self.share * conditions.joints_rad[:, self.source] * conditions.since(self.from_s)
        return effect.Deflection.of_joint(conditions, self.moved, angle)


def plant(change: effect.PlantedChange, site: effect.Site) -> JointCoupling:
    """Build the effect; the amplitude is angle over angle of the source [rad/rad]."""
    details = effect.read_details(CouplingDetails, change)
    moved = effect.joint_index(change, site.arm)
    neighbour = moved - 1 if moved > 0 else 1
    stated = details.source
    source = neighbour if stated is None else effect.joint_named(stated, change, 'key "source"', site.arm)
    if source == moved:
        raise ScenarioError(
            f'effect {change.name}: key "source" must be another joint than the subject, not "{stated}"'
        )
    return JointCoupling(moved, source, change.amplitude, change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[JointCoupling, ...]:
    """Build the identified couplings, `coupling_<moved>_<source>` [rad/rad], angles as the joints count."""
    form, n = "coupling_<moved>_<source>", site.arm.n_joints
    return tuple(
        JointCoupling(
            stated.index(moved, n, "joint"), stated.index(source, n, "joint"), share, effect.ALWAYS_S
        )
        for (moved, source), share in stated.matching(r"coupling_([0-9]+)_([0-9]+)", form)
    )
