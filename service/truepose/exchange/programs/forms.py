"""The forms in which the formats write positions, rotations and joint angles.

Six decimals of a millimetre round by 5e-7 mm, nine of a degree turn the end of a 3 m arm by 3e-8 mm. A
controller may keep fewer digits than its text can say: RAPID and KRL hold numbers in single precision.
"""

from collections.abc import Callable, Sequence
from math import degrees, radians
from typing import Final, Literal, TypeAlias

from truepose.exchange.programs.program import Form
from truepose.exchange.programs.rotations import (
    angles_about,
    from_vector,
    near_quaternion,
    near_vector,
    normalised,
    turns_about,
)

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
QUATERNION: Final = Form(normalised, near_quaternion, _QUATERNION_DECIMALS)
ROTATION_VECTOR: Final = Form(from_vector, near_vector, _RADIAN_DECIMALS)
XYZ_DEGREES: Final = turns_in_degrees("xyz")
ZYX_DEGREES: Final = turns_in_degrees("zyx")
