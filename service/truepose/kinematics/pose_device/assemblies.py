"""All assemblies of the pose device, those that a ballbar can measure, those that are worth measuring twice.

Each of 36 designs (144 with a fourth cup) goes together in four ways. All six legs then reach the tool
triangle from one side, and the arm's flange carries it on one side: where these are the same, the ballbar
would have to pass through the fixture. That leaves three turns of the tool for each shape instead of its six
labellings, hence half of the assemblies. By this rule solutions 1 and 3 (numbered as in table 3.1) want the
tool one way round and 2 and 4 the other, where the thesis' figure 3.5 has a and d against b and c: it numbers
them differently. Only so are there 18 close pairs among the 72, as its figure 3.7 shows.

References
----------
A. Nubiola, PhD thesis, ETS Montreal, 2014, section 3.2.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import Leg
from truepose.domain.errors import ConfigurationError
from truepose.kinematics.pose_device.cascade import Design, designs, sides, solve
from truepose.kinematics.poses import Pose, pose_of, turn_between

LEG_MM = 300.0  # the longest bars of the ballbar that have a calibrator: the widest working volume

_SAME_TURN_RAD = float(np.deg2rad(30.0))  # thesis section 3.2: poses closer than both tell the same
_SAME_PLACE_MM = 50.0


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class Assembly:
    """One way to put the pose device together.

    Attributes
    ----------
    number : int
        From 1.
    design : Design
    solution : int
        1..4, as in table 3.1 of the thesis.
    points_mm : ndarray, shape (3, 3)
        Nests T1, T2, T3 in the frame of the cups.
    pose : Pose
        Of the flange frame of the arm.
    """

    number: int  # from 1
    design: Design
    solution: int  # 1..4
    points_mm: FloatArray  # (3, 3) nests T1, T2, T3 in the frame of the cups
    pose: Pose

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The six legs, in the order of the cascade."""
        return self.design.legs

    @property
    def name(self) -> str:
        """What is shown of it, e.g. 1_12 2_123 3_1, solution 2."""
        return f"{self.design.name}, solution {self.solution}"


def assemblies(cups_mm: FloatArray, nests_mm: FloatArray, *, leg_mm: float = LEG_MM) -> tuple[Assembly, ...]:
    """Return every way to join cups and nests by six legs of one length; 144 for three cups, 576 for four.

    Parameters
    ----------
    cups_mm : ndarray, shape (3 or 4, 3)
        Cups of the base fixture in any frame.
    nests_mm : ndarray, shape (3, 3)
        Tool nests in the flange frame of the arm.
    leg_mm : float
        Length of all legs.

    Raises
    ------
    ConfigurationError
        Cups or nests are too few, or on a line.
    """
    check_triangle(nests_mm, "tool nests")
    tool_sides = sides(nests_mm)
    found: list[Assembly] = []
    for design in designs(len(cups_mm)):
        solutions = solve(design, cups_mm, tool_sides, np.full(6, leg_mm))
        for solution, points in enumerate(solutions, start=1):
            if np.isfinite(points).all():
                pose = pose_of(nests_mm, points)
                found.append(Assembly(len(found) + 1, design, solution, points, pose))
    return tuple(found)


def check_triangle(points_mm: FloatArray, what: str) -> None:
    """Refuse three points that form no triangle.

    Parameters
    ----------
    points_mm : ndarray, shape (3, 3)
    what : str
        What they are, in words of the sentence.

    Raises
    ------
    ConfigurationError
        They are not three finite points, or lie on a line.
    """
    if points_mm.shape != (3, 3) or not np.isfinite(points_mm).all():
        raise ConfigurationError(f"The {what} must be three rows of three finite numbers in mm.")
    if np.linalg.matrix_rank(points_mm[1:] - points_mm[0], tol=1e-6) < 2:
        raise ConfigurationError(f"The three {what} lie on a line; they must form a triangle.")


def measurable(
    candidates: Sequence[Assembly], cups_mm: FloatArray, nests_mm: FloatArray
) -> tuple[Assembly, ...]:
    """Return the assemblies whose legs all come to the tool from the side away from the flange.

    The flange is taken at the origin of the flange frame.

    Parameters
    ----------
    candidates : sequence of Assembly
    cups_mm : ndarray, shape (K, 3)
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.

    Raises
    ------
    ConfigurationError
        The nests are on a line, or the flange's origin lies in their plane, so that neither side is the
        flange's.
    """
    check_triangle(nests_mm, "tool nests")
    normal = np.cross(nests_mm[1] - nests_mm[0], nests_mm[2] - nests_mm[0])
    flange = float(-nests_mm[0] @ normal)
    if abs(flange) < 1e-6 * float(normal @ normal) ** 0.75:  # the normal is an area: its power 3/2 a volume
        raise ConfigurationError(
            "The flange is in the plane of the tool nests, so neither side is free for the legs."
        )
    return tuple(one for one in candidates if _reached_from_outside(one, cups_mm, normal * np.sign(flange)))


def _reached_from_outside(assembly: Assembly, cups_mm: FloatArray, towards_flange: FloatArray) -> bool:
    """Say whether every leg leaves its nest outwards: (cup - nest) . n > 0, n away from the flange."""
    outside = -(assembly.pose.rotation @ towards_flange)
    legs = (cups_mm[cup - 1] - assembly.points_mm[nest - 1] for cup, nest in assembly.legs)
    return all(float(leg @ outside) > 0.0 for leg in legs)


def distinct(
    candidates: Sequence[Assembly],
    *,
    turn_rad: float = _SAME_TURN_RAD,
    distance_mm: float = _SAME_PLACE_MM,
) -> tuple[Assembly, ...]:
    """Return the assemblies that are not close to an earlier one, in their order.

    Close means a turn below `turn_rad` and flange origins nearer than `distance_mm`, both at once:
    thesis section 3.2, where 18 of 72 go.

    Parameters
    ----------
    candidates : sequence of Assembly
    turn_rad, distance_mm : float, optional
    """
    kept: list[Assembly] = []
    for one in candidates:
        if not any(_close(one.pose, other.pose, turn_rad, distance_mm) for other in kept):
            kept.append(one)
    return tuple(kept)


def _close(first: Pose, second: Pose, turn_rad: float, distance_mm: float) -> bool:
    near = bool(np.linalg.norm(first.origin_mm - second.origin_mm) < distance_mm)
    return near and bool(turn_between(first.rotation, second.rotation) < turn_rad)
