"""Gravity on the arm where it truly is: the weights, and their torques r x F about the axes."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.arm import Bodies, CarriedMass, Vector
from truepose_simulators.physics.rigid import FloatArray, apply, move

# 1 kg in 1 m/s2 weighs 1 N; levers are in mm, so torques come out in N mm.
GRAVITY_M_S2 = (0.0, 0.0, -9.81)


@dataclass(frozen=True, slots=True)
class MassChange:
    """Mass that is there besides (or, negative, instead of) what the arm states."""

    joint: int  # 1-based, that carries it
    mass_kg: FloatArray  # (n,)
    centre_mm: Vector | FloatArray  # zero configuration, base frame; of the tool: flange frame
    on_tool: bool = False


@dataclass(frozen=True, slots=True)
class PlacedMass:
    """A mass where it is in n configurations."""

    joint: int  # 1-based, that carries it
    mass_kg: float | FloatArray  # one for all, or (n,)
    centre_mm: FloatArray  # (n, 3) world

    @property
    def first_moment_kg_mm(self) -> FloatArray:
        """Mass times place, shape (n, 3)."""
        if isinstance(self.mass_kg, float):
            return self.mass_kg * self.centre_mm
        return self.mass_kg[:, np.newaxis] * self.centre_mm


def place_masses(
    bodies: Bodies, masses: Iterable[CarriedMass], tool: CarriedMass | None, changes: Iterable[MassChange]
) -> tuple[PlacedMass, ...]:
    """Carry the masses along with the bodies.

    Parameters
    ----------
    bodies : Bodies
        Of n configurations.
    masses : iterable of CarriedMass
        Of the arm, places in the zero configuration.
    tool : CarriedMass or None
        Its place is stated in the flange frame.
    changes : iterable of MassChange
        What truly differs from that.
    """
    placed = [_placed(bodies, item.joint, item.mass_kg, item.centre_of_gravity_mm, False) for item in masses]
    if tool is not None:
        placed.append(_placed(bodies, tool.joint, tool.mass_kg, tool.centre_of_gravity_mm, True))
    placed += [_placed(bodies, item.joint, item.mass_kg, item.centre_mm, item.on_tool) for item in changes]
    return tuple(placed)


def _placed(
    bodies: Bodies, joint: int, mass_kg: float | FloatArray, centre_mm: Vector | FloatArray, on_tool: bool
) -> PlacedMass:
    carrier = bodies.last_frame if on_tool else bodies.placements[:, joint]
    return PlacedMass(joint, mass_kg, move(carrier, np.asarray(centre_mm)))


def gravity_torques(
    bodies: Bodies, masses: Sequence[PlacedMass], gravity_m_s2: Vector = GRAVITY_M_S2
) -> FloatArray:
    """Torque of gravity (world) about every joint axis [N mm], positive along the axis, shape (n, J).

    tau_j = z_j . (sum of m (r - p_j)) x g over all masses on joint j and beyond; z_j and p_j are direction
    and a point of the axis. Masses and first moments are summed once, so each joint costs the same.
    """
    n, n_joints = bodies.axis_points_mm.shape[:2]
    mass = np.zeros((n, n_joints, 1))
    first_moment = np.zeros((n, n_joints, 3))  # [kg mm] of what hangs on each joint alone
    for item in masses:
        mass[:, item.joint - 1, 0] += item.mass_kg
        first_moment[:, item.joint - 1] += item.first_moment_kg_mm
    levers = _sum_beyond(first_moment) - _sum_beyond(mass) * bodies.axis_points_mm
    torques: FloatArray = np.einsum("nji,nji->nj", _moments(levers, gravity_m_s2), bodies.axis_directions)
    return torques


def overturning_moment_n_mm(
    masses: Sequence[PlacedMass],
    n: int,
    gravity_m_s2: Vector,
    about_mm: FloatArray,
) -> FloatArray:
    """Moment of all weights about a point (3,) of the world [N mm], shape (n, 3)."""
    mass = sum((np.asarray(item.mass_kg) for item in masses), start=np.zeros(n))
    levers = sum((item.first_moment_kg_mm for item in masses), start=np.zeros((n, 3)))
    return _moments(levers - mass[:, np.newaxis] * about_mm, gravity_m_s2)


def _sum_beyond(per_joint: FloatArray) -> FloatArray:
    """Sum over a joint and all that follow it along the arm (axis 1)."""
    return np.cumsum(per_joint[:, ::-1], axis=1)[:, ::-1]


def _moments(levers_kg_mm: FloatArray, gravity_m_s2: Vector) -> FloatArray:
    x, y, z = gravity_m_s2
    # r x g as a matrix product: cheaper than np.cross for a single configuration
    return apply(np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]), levers_kg_mm)
