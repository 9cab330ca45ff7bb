"""Clearance of arm and tool along straight joint motions, the ballbar off, and off the cup of a set-up.

At a set-up the tool leaves the cup along the cup's axis.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.kinematics.inverse import all_branches, brought_within
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture, chain_of, pose_in_base
from truepose.planning.ballbar.clearance import Bodies, arm_room_mm, bodies_at, without_cups
from truepose.planning.errors import NoWayError

RETREATS_MM: Final = (60.0, 120.0, 200.0)
_CHECK_RAD: Final = float(np.radians(2.0))  # between two checks; a nest then moves by 30 mm at most
_SAME_BRANCH_RAD: Final = 1.0  # a retreat that turns a joint by more is another branch
_ROUNDING_MM: Final = 1e-6  # stops that just keep their room keep it still after a turn of their joints


@dataclass(frozen=True, slots=True)
class Stop:
    """A configuration where the arm stops; at a set-up, which cup the tool touches there.

    Attributes
    ----------
    joints_rad : ndarray, shape (J,)
    base_point : int or None
        1-based; None: the tool touches nothing.
    """

    joints_rad: FloatArray
    base_point: int | None = None


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What the arm moves among."""

    cell: BallbarCell
    fixture: BaseFixture


def lift(around: Surroundings, stop: Stop) -> list[FloatArray]:
    """Return the stop, and at a set-up the configuration where the tool has left the cup along its axis.

    Parameters
    ----------
    around : Surroundings
    stop : Stop

    Returns
    -------
    list of ndarray, shape (J,)
        One, or at a set-up two: the stop first.

    Raises
    ------
    NoWayError
        The tool cannot leave the cup.
    """
    if stop.base_point is None:
        return [stop.joints_rad]
    axis = around.fixture.axes[stop.base_point - 1]
    for distance in RETREATS_MM:
        lifted = shifted(around.cell, stop.joints_rad, distance * axis)
        if lifted is not None and _lifts_clear(around, stop, lifted):
            return [stop.joints_rad, lifted]
    raise NoWayError(
        f"The tool cannot retract from base point {stop.base_point} of placement {around.fixture.number} "
        "along the cup axis. Move the base fixture."
    )


def can_lift(around: Surroundings, stop: Stop) -> bool:
    """Return whether the tool can leave the cup of a set-up.

    Parameters
    ----------
    around : Surroundings
    stop : Stop

    Returns
    -------
    bool
        True of a stop that touches no cup.
    """
    try:
        lift(around, stop)
    except NoWayError:
        return False
    return True


def _lifts_clear(around: Surroundings, stop: Stop, lifted: FloatArray) -> bool:
    """Whether the lift is clear but for the cups that part, and its end altogether."""
    if not is_clear_along(around, lifted[None]):
        return False
    bodies = bodies_at(around.cell, around.fixture, between(stop.joints_rad, lifted))
    return _roomy(around, without_cups(bodies, int(stop.base_point or 0)))


def is_clear_along(around: Surroundings, joints_rad: FloatArray) -> bool:
    """Return whether all configurations are clear and within the ranges.

    Parameters
    ----------
    around : Surroundings
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    bool
    """
    _, within = brought_within(joints_rad, around.cell.ranges)
    if not within.all():
        return False
    return _roomy(around, bodies_at(around.cell, around.fixture, joints_rad))


def _roomy(around: Surroundings, bodies: Bodies) -> bool:
    return bool((arm_room_mm(bodies) >= around.cell.arm_room_mm - _ROUNDING_MM).all())


def between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the configurations that are looked at along a straight joint motion, both ends included.

    Parameters
    ----------
    start, end : ndarray, shape (J,)

    Returns
    -------
    ndarray, shape (n, J)
        At most 2 deg apart in every joint.
    """
    steps = max(1, int(np.ceil(np.max(np.abs(end - start)) / _CHECK_RAD)))
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    return np.asarray((1.0 - share) * start + share * end)


def shifted(cell: BallbarCell, joints: FloatArray, shift_mm: FloatArray) -> FloatArray | None:
    """Return joints on the same branch with the tool shifted, its orientation kept.

    Parameters
    ----------
    cell : BallbarCell
    joints : ndarray, shape (J,)
    shift_mm : ndarray, shape (3,)
        In the world.

    Returns
    -------
    ndarray, shape (J,), or None
        None where no branch is near, or it leaves the ranges.
    """
    chain = chain_of(cell, joints[None])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = chain.end_rotation[0], chain.end_origin[0] + shift_mm
    found = all_branches(cell.robot, pose_in_base(cell, pose[None]))[0]
    # Angles of an inverse are of any turn: the one nearest to where the arm is.
    turned = found - 2 * np.pi * np.round((found - joints) / (2 * np.pi))
    apart = np.where(np.isnan(turned).any(axis=1), np.inf, np.abs(turned - joints).max(axis=1))
    best = int(np.argmin(apart))
    if apart[best] > _SAME_BRANCH_RAD:
        return None
    low = np.array([limit.lower_rad for limit in cell.ranges])
    high = np.array([limit.upper_rad for limit in cell.ranges])
    return turned[best] if bool(np.all((turned[best] >= low) & (turned[best] <= high))) else None
