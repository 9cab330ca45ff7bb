"""Where the arm comes to rest: gearboxes wound up until they balance gravity where the arm truly is."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import SimulatorError
from truepose_simulators.physics.chain import Bodies, link_motions, place_bodies
from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads
from truepose_simulators.physics.effects.ports import ArmEffect
from truepose_simulators.physics.loads import MassChange, gravity_torques, place_masses
from truepose_simulators.physics.plant import Plant
from truepose_simulators.physics.rigid import FloatArray, move

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
        """Positions of points of the last frame [mm, world]: shape (m, 3) or (n, m, 3) -> (n, m, 3)."""
        return move(self.bodies.last_frame[:, np.newaxis], nests_mm)


def find_rest(
    plant: Plant,
    effects: Iterable[ArmEffect],
    conditions: Conditions,
    mass_changes: Sequence[MassChange] = (),
) -> Rest:
    """Let the arm come to rest under gravity.

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
    raise NoEquilibriumError("the gearbox springs are too soft: the arm finds no rest under its own weight")


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
