"""The forms in which programs write positions, rotations (as unit quaternions, w first, and back) and joints.

Three angles and a rotation vector stand for the same rotation in several ways: the one that is nearest to
the numbers that stood in the file is written, so that a small correction changes them a little only.

Six decimals of a millimetre round by 5e-7 mm, nine of a degree turn the end of a 3 m arm by 3e-8 mm. A
controller may keep fewer digits than its text can say: RAPID and KRL hold numbers in single precision.
"""

from collections.abc import Callable, Iterator, Sequence
from math import atan2, cos, degrees, hypot, pi, radians, remainder, sin, sqrt, tau
from typing import Final, Literal, TypeAlias

import numpy as np

from truepose.exchange.programs.program import Form, Pose, Quaternion, Triple
from truepose.kinematics.frames import angles_xyz, rotation_from_quaternion

Numbers: TypeAlias = Sequence[float]
_AXES: Final = "xyz"
_MOST_OFF_UNIT: Final = 0.01  # four decimals are off by 1e-4
_NO_TURN_RAD: Final = 1e-12  # shorter rotation vectors have no direction


def normalise(numbers: Numbers) -> Quaternion:
    """Return a quaternion of norm 1; the zero quaternion is returned as it is."""
    w, x, y, z = numbers
    norm = sqrt(w * w + x * x + y * y + z * z) or 1.0
    return w / norm, x / norm, y / norm, z / norm


def is_orientation(numbers: Numbers) -> bool:
    """Whether four numbers of a file were meant as an orientation: their norm is near 1."""
    return abs(hypot(*numbers) - 1.0) <= _MOST_OFF_UNIT


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Return the rotation that turns by `second`, then by `first` (both in the axes of `first`)."""
    a, b, c, d = first
    w, x, y, z = second
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def conjugate(quaternion: Quaternion) -> Quaternion:
    """Return the rotation back."""
    w, x, y, z = quaternion
    return w, -x, -y, -z


def rotate(quaternion: Quaternion, vector: Triple) -> Triple:
    """Return a vector turned by a rotation."""
    _, x, y, z = product(product(quaternion, (0.0, *vector)), conjugate(quaternion))
    return x, y, z


def compose(outer: Pose, inner: Pose) -> Pose:
    """Return the pose of `inner`, which is given in the frame `outer`, in the frame of `outer`."""
    x, y, z = rotate(outer.quaternion, inner.position_mm)
    a, b, c = outer.position_mm
    return Pose((a + x, b + y, c + z), normalise(product(outer.quaternion, inner.quaternion)))


def near_quaternion(quaternion: Numbers, stood: Numbers) -> Numbers:
    """Return the quaternion or its negative, which is the same rotation, whichever is nearer to `stood`."""
    against = sum(a * b for a, b in zip(quaternion, stood, strict=True)) < 0
    return [-number for number in quaternion] if against else quaternion


def turns_about(axes: str) -> Callable[[Numbers], Quaternion]:
    """Return what makes a quaternion of angles [rad], each about its axis as turned by those before it."""

    def quaternion_of(angles_rad: Numbers) -> Quaternion:
        result: Quaternion = (1.0, 0.0, 0.0, 0.0)
        for axis, angle in zip(axes, angles_rad, strict=True):
            result = product(result, _about(axis, angle))
        return result

    return quaternion_of


def angles_about(axes: str) -> Callable[[Numbers, Numbers], Numbers]:
    """Return the inverse of `turns_about` for "xyz" and "zyx", near to angles that stood there."""
    return {"xyz": _near_xyz, "zyx": _near_zyx}[axes]


def from_vector(vector_rad: Numbers) -> Quaternion:
    """Return the quaternion of a rotation vector."""
    x, y, z = vector_rad
    angle = sqrt(x * x + y * y + z * z)
    if angle < _NO_TURN_RAD:
        return normalise((1.0, x / 2, y / 2, z / 2))
    share = sin(angle / 2) / angle
    return cos(angle / 2), x * share, y * share, z * share


def near_vector(quaternion: Numbers, stood_rad: Numbers) -> Numbers:
    """Return the rotation vector, with whole turns more or less, that is nearest to `stood_rad`."""
    w, x, y, z = quaternion
    length = sqrt(x * x + y * y + z * z)
    if length < _NO_TURN_RAD:
        return 2 * x, 2 * y, 2 * z
    angle = 2 * atan2(length, w)
    turns = [angle + turn * tau for turn in (-2, -1, 0, 1)]
    return min(
        ([turn * part / length for part in (x, y, z)] for turn in turns),
        key=lambda vector: _distance(vector, stood_rad),
    )


def _about(axis: str, angle_rad: float) -> Quaternion:
    parts = [0.0, 0.0, 0.0]
    parts[_AXES.index(axis)] = sin(angle_rad / 2)
    x, y, z = parts
    return cos(angle_rad / 2), x, y, z


def _near_xyz(quaternion: Numbers, stood_rad: Numbers) -> Numbers:
    return _nearest(angles_xyz(rotation_from_quaternion(np.asarray(quaternion))), stood_rad)


def _near_zyx(quaternion: Numbers, stood_rad: Numbers) -> Numbers:
    # The way back turns about the same axes in the other order.
    x, y, z = angles_xyz(rotation_from_quaternion(np.asarray(quaternion)).T)
    return _nearest((-z, -y, -x), stood_rad)


def _nearest(angles_rad: Triple, stood_rad: Numbers) -> Numbers:
    """Return the same rotation by the three angles, or by the three others, that are nearest."""
    return min(_ways(angles_rad, stood_rad), key=lambda way: _distance(way, stood_rad))


def _ways(angles_rad: Triple, stood_rad: Numbers) -> Iterator[list[float]]:
    first, second, third = angles_rad
    for way in ((first, second, third), (first + pi, pi - second, third + pi)):
        yield [stood + remainder(angle - stood, tau) for angle, stood in zip(way, stood_rad, strict=True)]


def _distance(first: Numbers, second: Numbers) -> float:
    return hypot(*(a - b for a, b in zip(first, second, strict=True)))


_MM_DECIMALS: Final = 6
_DEGREE_DECIMALS: Final = 9
_RADIAN_DECIMALS: Final = 11
_QUATERNION_DECIMALS: Final = 10
Order: TypeAlias = Literal["xyz", "zyx", "fixed xyz"]


def _every(convert: Callable[[float], float]) -> Callable[[Sequence[float]], tuple[float, ...]]:
    return lambda numbers: tuple(map(convert, numbers))


def _scaled(inward: Callable[[float], float], outward: Callable[[float], float], decimals: int) -> Form:
    return Form(_every(inward), lambda values, _: _every(outward)(values), decimals)


def millimetres(decimals: int = _MM_DECIMALS) -> Form:
    """Return the form of a position in mm."""
    return _scaled(float, float, decimals)


def degrees_of_joints(decimals: int = _DEGREE_DECIMALS) -> Form:
    """Return the form of joint angles in degrees."""
    return _scaled(radians, degrees, decimals)


def turns_in_degrees(order: Order, decimals: int = _DEGREE_DECIMALS) -> Form:
    """Return the form of a rotation by three angles in degrees.

    Parameters
    ----------
    order : "xyz", "zyx" or "fixed xyz"
        The axes of the three numbers in their order, each turned by those before it: "zyx" is
        RotZ(first) RotY(second) RotX(third). With "fixed xyz" the axes stay, which is
        RotZ(third) RotY(second) RotX(first).
    decimals : int
        That the format takes.
    """
    backwards = order == "fixed xyz"
    axes = "zyx" if backwards else order
    step = -1 if backwards else 1
    make, take = turns_about(axes), angles_about(axes)

    def outward(quaternion: Sequence[float], stood_deg: Sequence[float]) -> Sequence[float]:
        return [degrees(angle) for angle in take(quaternion, [radians(a) for a in stood_deg[::step]])][::step]

    return Form(lambda numbers: make([radians(a) for a in numbers[::step]]), outward, decimals)


MILLIMETRES: Final = millimetres()
METRES: Final = _scaled(lambda m: m * 1e3, lambda mm: mm / 1e3, _MM_DECIMALS + 3)
INCHES: Final = _scaled(lambda inch: inch * 25.4, lambda mm: mm / 25.4, _MM_DECIMALS + 2)
JOINT_DEGREES: Final = degrees_of_joints()
JOINT_RADIANS: Final = _scaled(float, float, _RADIAN_DECIMALS)
QUATERNION: Final = Form(normalise, near_quaternion, _QUATERNION_DECIMALS)
ROTATION_VECTOR: Final = Form(from_vector, near_vector, _RADIAN_DECIMALS)
XYZ_DEGREES: Final = turns_in_degrees("xyz")
ZYX_DEGREES: Final = turns_in_degrees("zyx")
