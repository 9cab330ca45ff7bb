"""One true robot: its own errors, springs and tool, and where it comes to rest against gravity."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from truepose_simulators.errors import ScenarioError, SimulatorError
from truepose_simulators.physics.arm import Arm, Bodies, CarriedMass, Vector, link_motions, place_bodies
from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads
from truepose_simulators.physics.effects.ports import ArmEffect
from truepose_simulators.physics.loads import GRAVITY_M_S2, MassChange, gravity_torques, place_masses
from truepose_simulators.physics.rigid import FloatArray, move
from truepose_simulators.scenarios.table import require_at_least_0


@dataclass(frozen=True, slots=True)
class GearboxSprings:
    """One spring per joint."""

    compliance_rad_per_n_mm: FloatArray  # (J,)

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the wind-up of every gearbox."""
        del conditions
        return Deflection(angles_rad=self.compliance_rad_per_n_mm * loads.torque_n_mm)


@dataclass(frozen=True)
class Plant:
    """The truth about one robot. `motions` as in `arm.link_motions`: base, links, tool."""

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
            raise ScenarioError(
                f'key "compliance_factor" must be a rising range from 0 or more, not {low} to {high}'
            )
        require_at_least_0(self, *(name for name in self.__dataclass_fields__ if name != "compliance_factor"))


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


# Torques agree to 1e-4 N mm, far below 1e-9 rad with the softest gear in use (1e-6 rad/(N mm)).
_TORQUE_TOLERANCE_N_MM = 1e-4
# What weighs without a stated mass shows in the angles alone: 1e-9 rad are 1e-6 mm at a metre.
_ANGLE_TOLERANCE_RAD = 1e-9
# Each step gains a factor c * dtau/dq, about 0.01 for these arms; a rubber arm would need more.
_MOST_STEPS = 40


class NoEquilibriumError(SimulatorError):
    """The springs are too soft: the arm folds under its own weight."""


@dataclass(frozen=True, slots=True)
class Rest:
    """The arm at rest in n configurations."""

    angles_rad: FloatArray  # (n, J) true angles
    torque_n_mm: FloatArray  # (n, J)
    bodies: Bodies

    def nest_positions(self, nests_mm: FloatArray) -> FloatArray:
        """Positions of points of the flange frame [mm, world]: shape (m, 3) or (n, m, 3) -> (n, m, 3)."""
        return move(self.bodies.last_frame[:, np.newaxis], nests_mm)


def find_rest(
    plant: Plant,
    effects: Iterable[ArmEffect],
    conditions: Conditions,
    mass_changes: Sequence[MassChange] = (),
) -> Rest:
    """Let the arm come to rest under gravity.

    The torques wind up the springs, and the arm that gave way is torqued otherwise: repeated until neither
    changes, angles_(k+1) = commanded + deflections(torque(angles_k)).

    Parameters
    ----------
    plant : Plant
        The true arm; its gearbox springs act always.
    effects : iterable of ArmEffect
        What acts besides.
    conditions : Conditions
        Of n stops.
    mass_changes : sequence of MassChange
        Masses that differ from those of the plant.

    Raises
    ------
    NoEquilibriumError
        The fixed point of torque and deflection is not reached.
    """
    acting = (plant.springs, *effects)
    loads = Loads(np.zeros_like(conditions.joints_rad), gravity_m_s2=plant.gravity_m_s2)
    before = conditions.joints_rad
    # Torques of the arm as it is drawn are off by about a thousandth: 1 um at 1 mm of deflection, which would
    # be found later and blamed on something else (decision 0003).
    for _ in range(_MOST_STEPS):
        deflections = [effect.deflect(conditions, loads) for effect in acting]
        angles = conditions.joints_rad + _total_angles(deflections)
        bodies = place_bodies(plant.arm, _errors(plant, deflections), angles)
        masses = place_masses(bodies, plant.arm.masses, plant.tool_mass, mass_changes)
        torque = _load(conditions, gravity_torques(bodies, masses, plant.gravity_m_s2))
        balanced = _agree(torque, loads.torque_n_mm, _TORQUE_TOLERANCE_N_MM)
        # An effect that looks at the placed arm has said nothing before there was one.
        if loads.bodies is not None and balanced and _agree(angles, before, _ANGLE_TOLERANCE_RAD):
            return Rest(angles, torque, bodies)
        loads, before = Loads(torque, masses, bodies, plant.gravity_m_s2), angles
    raise NoEquilibriumError(
        "the gearboxes are too compliant: the arm finds no equilibrium under its own weight"
    )


def _load(conditions: Conditions, gravity_n_mm: FloatArray) -> FloatArray:
    """Return what winds up the gearboxes: the measured torque where there is one."""
    measured = conditions.measured_torque_n_mm
    return gravity_n_mm if measured is None else measured


def _agree(now: FloatArray, before: FloatArray, tolerance: float) -> bool:
    return bool(np.max(np.abs(now - before), initial=0.0) < tolerance)


def _total_angles(deflections: Iterable[Deflection]) -> FloatArray | float:
    return sum((item.angles_rad for item in deflections if item.angles_rad is not None), start=0.0)


def _errors(plant: Plant, deflections: Iterable[Deflection]) -> FloatArray:
    motions = [item.motions for item in deflections if item.motions is not None]
    if not motions:
        return plant.errors
    added = link_motions(plant.arm, np.asarray(sum(motions)))
    errors: FloatArray = plant.errors @ added
    # The base is the only body whose motions are stated in the world, before its own placement.
    errors[..., 0, :, :] = added[..., 0, :, :] @ plant.errors[0]
    return errors
