"""A gearbox that is softer (or stiffer) than the plant's own spring."""

from dataclasses import dataclass

from simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from simulators.physics.effects.site import NoDetails, Site, read_details
from simulators.physics.effects.subject import joint_index


@dataclass(frozen=True, slots=True)
class ExtraSpring:
    """A second spring in series with the gearbox of joint `joint` (0-based)."""

    joint: int
    compliance_rad_per_n_mm: float
    from_s: float

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the wind-up of this spring."""
        wound = self.compliance_rad_per_n_mm * loads.torque_n_mm[:, self.joint]
        return Deflection.of_joint(conditions, self.joint, wound * conditions.since(self.from_s))


def plant(change: PlantedChange, site: Site) -> ExtraSpring:
    """Build the effect; the amplitude is the compliance [rad/(N mm)] that comes on top."""
    read_details(NoDetails, change)
    return ExtraSpring(joint_index(change, site.arm), change.amplitude, change.from_s)
