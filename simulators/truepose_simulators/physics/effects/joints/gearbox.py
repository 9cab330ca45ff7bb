"""Gearboxes as linear torsion springs: angle c_i * tau_i at the torque that truly acts."""

from dataclasses import dataclass

from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class GearboxSprings:
    """One spring per joint."""

    compliance_rad_per_n_mm: FloatArray  # (J,)

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the wind-up of every gearbox."""
        del conditions
        return Deflection(angles_rad=self.compliance_rad_per_n_mm * loads.torque_n_mm)
