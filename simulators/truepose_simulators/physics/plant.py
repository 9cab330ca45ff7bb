"""One true robot: the nominal arm with its own errors and springs, its tool, and how to draw one."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm, CarriedMass, Vector
from truepose_simulators.physics.chain import link_motions
from truepose_simulators.physics.effects.joints.gearbox import GearboxSprings
from truepose_simulators.physics.loads import GRAVITY_M_S2
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True)
class Plant:
    """The truth about one robot. `motions` as in `chain.link_motions`: base, links, tool."""

    arm: Arm
    motions: FloatArray  # (J+2, 6) [mm, rad]
    compliance_rad_per_n_mm: FloatArray  # (J,)
    tool_mass: CarriedMass | None
    gravity_m_s2: Vector = GRAVITY_M_S2  # world

    @cached_property
    def springs(self) -> GearboxSprings:
        """The gearboxes."""
        return GearboxSprings(self.compliance_rad_per_n_mm)

    @cached_property
    def errors(self) -> FloatArray:
        """The rigid motions in the base frame, shape (J+2, 4, 4)."""
        return link_motions(self.arm, self.motions)


@dataclass(frozen=True, slots=True)
class PlantSizes:
    """Sizes of random errors, one standard deviation each; a factor is uniform between its bounds."""

    link_translation_mm: float = 0.12  # along each axis of the seat
    link_rotation_across_rad: float = 0.35e-3  # about the two axes across the joint axis
    link_rotation_about_rad: float = 0.8e-3  # about the joint axis
    parallel_axis_tilt_rad: float = 0.35e-3  # about y of a joint whose axis is parallel to the previous one
    base_translation_mm: float = 0.1
    base_rotation_rad: float = 0.3e-3
    compliance_factor: tuple[float, float] = (0.8, 1.25)

    def __post_init__(self) -> None:
        low, high = self.compliance_factor
        if not 0.0 <= low <= high:
            raise ScenarioError(f'key "compliance_factor" must rise from 0 or more, not {low} to {high}')
        for name in self.__dataclass_fields__:
            if name != "compliance_factor" and getattr(self, name) < 0.0:
                raise ScenarioError(f'key "{name}" must be 0 or more, not {getattr(self, name)}')


def draw_motions(arm: Arm, sizes: PlantSizes, rng: np.random.Generator) -> FloatArray:
    """Draw rigid motions of base and links, shape (J+2, 6); the tool has none.

    The same generator state gives the same motions whatever the sizes, up to their scale: `clean` and
    `tilted` cells of one seed differ in the tilt alone.
    """
    motions = np.zeros((arm.n_joints + 2, 6))
    unit = rng.standard_normal((arm.n_joints + 1, 6))
    base = [sizes.base_translation_mm] * 3 + [sizes.base_rotation_rad] * 3
    motions[0] = unit[0] * base
    across = sizes.link_rotation_across_rad
    for i in range(arm.n_joints):
        tilt = sizes.parallel_axis_tilt_rad if arm.parallel_to_previous(i) else across
        scale = [sizes.link_translation_mm] * 3 + [across, tilt, sizes.link_rotation_about_rad]
        motions[i + 1] = unit[i + 1] * scale
    return motions


def draw_compliances(arm: Arm, sizes: PlantSizes, rng: np.random.Generator) -> FloatArray:
    """Draw gearbox compliances [rad/(N mm)], shape (J,)."""
    return np.array(arm.typical_compliance_rad_per_n_mm) * rng.uniform(*sizes.compliance_factor, arm.n_joints)
