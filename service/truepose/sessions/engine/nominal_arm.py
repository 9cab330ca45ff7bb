"""Where the nominal model expects a tool nest; good to the robot's own errors, a few millimetres."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, Nest, Robot
from truepose.domain.session import Vector
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.messages.message import message
from truepose.sessions.errors import PlanRefusedError


def nominal_chain(robot: Robot, base: FramePlacement, joints_rad: FloatArray) -> Chain:
    """Return the nominal frames of configurations of shape (n, J), in the world."""
    return forward(nominal_values(robot, joints_rad), placement_rotation(base), placement_translation(base))


def nest_centre(nests: tuple[Nest, ...], nest: int) -> FloatArray:
    """Return the centre of a 1-based nest in the flange frame [mm]; raises PlanRefusedError where unknown."""
    if not 1 <= nest <= len(nests):
        raise PlanRefusedError(message("session.nest.unknown", nest=nest, there=len(nests)))
    centre = nests[nest - 1].centre_mm
    if centre is None:
        raise PlanRefusedError(message("session.nest.no_centre", nest=nest))
    return np.array(centre)


def nest_in_world(
    robot: Robot, base: FramePlacement, nests: tuple[Nest, ...], joints_rad: tuple[float, ...], nest: int
) -> FloatArray:
    """Return where a tool nest nominally is [mm, world], shape (3,)."""
    chain = nominal_chain(robot, base, np.array([joints_rad]))
    point: FloatArray = chain.points(nest_centre(nests, nest))[0]
    return point


def arm_line(chain: Chain, number: int = 0) -> tuple[FloatArray, ...]:
    """Return base, joints and flange of one configuration as a line: along each link, then each axis."""
    line = [chain.base_origin[0]]
    for middle, origin in zip(chain.origin_middle[:, number], chain.origin[:, number], strict=True):
        # Zero lengths are left out: a picture of one point twice has no direction.
        line += [point for point in (middle, origin) if not np.allclose(point, line[-1], atol=0.1)]
    return tuple(line)


def as_vector(point: FloatArray, digits: int | None = None) -> Vector:
    """Return a point, shape (3,), as plain numbers; rounded to `digits` where they are given."""
    x, y, z = (float(value) if digits is None else round(float(value), digits) for value in point)
    return x, y, z
