"""An arm drawn from a DH-Modified table: where its axes lie while all joints read zero.

The table is walked once, at zero; from there on the arm is one of screw axes like those read off drawings.
A row does RotX(alpha) TransX(a) RotZ(sign * q + offset) TransZ(d) (J. J. Craig, Introduction to Robotics,
3rd ed., 2005, section 3.4). The seat of a joint is at the origin of its frame, with x along the common
normal of its axis and the one before, and z along the sense in which the joint counts.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.arm import Arm, CarriedMass, JointAxis, Vector
from truepose_simulators.physics.rigid import FloatArray, inverse, move, pose_matrix, to_six

_FASTEST_RAD_S = math.radians(250.0)  # a small arm's; no model states speeds
_FULL_TURN_RAD = 2.0 * math.pi
_LONGEST_NAME = 30  # a RAPID string holds 80 characters, with serial number and version before it
_COUNTS_BACKWARDS = np.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, slots=True)
class TableRow:
    """One row of the table."""

    alpha_rad: float
    a_mm: float
    offset_rad: float
    d_mm: float
    sign: int  # 1 or -1: sense in which the joint counts, about z of its frame


@dataclass(frozen=True, slots=True)
class RowErrors:
    """What is wrong with one row; beta turns about y between alpha and theta (Hayati)."""

    alpha_rad: float = 0.0
    a_mm: float = 0.0
    beta_rad: float = 0.0
    theta_rad: float = 0.0
    d_mm: float = 0.0


@dataclass(frozen=True, slots=True)
class FrameMass:
    """A mass stated in the frame of one joint (1-based)."""

    joint: int
    mass_kg: float
    centre_of_gravity_mm: Vector


@dataclass(frozen=True, slots=True)
class ArmTable:
    """What the maker states of an arm."""

    name: str
    rows: tuple[TableRow, ...]
    masses: tuple[FrameMass, ...]
    limits_rad: tuple[tuple[float, float], ...] | None  # None: not stated
    calibration_rad: tuple[tuple[float, float], ...] | None  # where configurations are chosen
    gear_ratio: tuple[float, ...] | None
    typical_compliance_rad_per_n_mm: tuple[float, ...] | None


def zero_frames(rows: Sequence[TableRow]) -> FloatArray:
    """Frames of all joints while they read zero, in the base frame, shape (J, 4, 4)."""
    frames, frame = [], np.eye(4)
    for row in rows:
        frame = frame @ _row(row.alpha_rad, row.a_mm, 0.0, row.offset_rad, row.d_mm)
        frames.append(frame)
    return np.array(frames)


def link_motion(row: TableRow, errors: RowErrors) -> FloatArray:
    """Motion (6,) of a link, in the seat of its joint, that makes the nominal row the erroneous one."""
    # RotX and TransX commute, and so do RotZ and TransZ: the errors of a row may stand together between its
    # two halves. The seat is further on by d along z, and turned where the joint counts backwards.
    error = _row(errors.alpha_rad, errors.a_mm, errors.beta_rad, errors.theta_rad, errors.d_mm)
    seat = _along_z(row.d_mm) @ _sense(row)
    return to_six(inverse(seat) @ error @ seat)


def draw_arm(table: ArmTable) -> Arm:
    """Return the nominal arm; what the table leaves open is as wide as the physics allows."""
    frames, rows = zero_frames(table.rows), table.rows
    befores = np.concatenate([np.eye(4)[np.newaxis], frames[:-1]])
    limits = table.limits_rad or ((-_FULL_TURN_RAD, _FULL_TURN_RAD),) * len(rows)
    joints = tuple(
        _joint(row, before, limit) for row, before, limit in zip(rows, befores, limits, strict=True)
    )
    masses = (
        CarriedMass(mass.joint, mass.mass_kg, vector(move(frames[mass.joint - 1], _array(mass))))
        for mass in table.masses
    )
    last = frames[-1]
    return Arm(
        name=table.name,
        model=_type_plate(table.name),
        joints=joints,
        masses=tuple(masses),
        flange_mm=vector(last[:3, 3]),
        flange_x=vector(last[:3, 0]),
        flange_z=vector(last[:3, 2]),
        typical_compliance_rad_per_n_mm=table.typical_compliance_rad_per_n_mm or (0.0,) * len(rows),
        gear_ratio=table.gear_ratio or (math.inf,) * len(rows),
    )


def _joint(row: TableRow, before: FloatArray, limit: tuple[float, float]) -> JointAxis:
    seat = before @ _row(row.alpha_rad, row.a_mm, 0.0, 0.0, row.d_mm) @ _sense(row)
    place, axis, normal = (vector(seat[:3, column]) for column in (3, 2, 0))
    return JointAxis(place, axis, normal, *limit, _FASTEST_RAD_S)


def _row(alpha_rad: float, a_mm: float, beta_rad: float, theta_rad: float, d_mm: float) -> FloatArray:
    """RotX(alpha) TransX(a) RotY(beta) RotZ(theta) TransZ(d)."""
    across = pose_matrix(np.array([a_mm, 0.0, 0.0]), np.array([alpha_rad, 0.0, 0.0]))
    about = pose_matrix(np.zeros(3), np.array([0.0, beta_rad, theta_rad]))
    joined: FloatArray = across @ about @ _along_z(d_mm)
    return joined


def _along_z(d_mm: float) -> FloatArray:
    return pose_matrix(np.array([0.0, 0.0, d_mm]), np.zeros(3))


def _sense(row: TableRow) -> FloatArray:
    return np.eye(4) if row.sign > 0 else _COUNTS_BACKWARDS


def _type_plate(name: str) -> str:
    """Return a name as a controller says it: short, printable, without the stars that part its answer."""
    plain = "".join(letter if letter.isascii() and letter.isprintable() else "?" for letter in name)
    return plain.replace("*", "?")[:_LONGEST_NAME]


def _array(mass: FrameMass) -> FloatArray:
    return np.array(mass.centre_of_gravity_mm)


def vector(values: FloatArray) -> Vector:
    """Return three numbers as plain ones."""
    x, y, z = (float(value) for value in values)
    return x, y, z
