"""The arm in configurations as capsules, for pictures only: its thickness is a guess from its reach."""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, Robot
from truepose.planning.ballbar.clear_ways.bodies import arm_body, arm_links, chain_of, table_arm_radii_mm
from truepose.planning.work_volume.cell_bodies import arm_outline

_TABLE_REACH_MM: Final = 1000.0  # stretched length of the arms that `table_arm_radii_mm` were read off
_LEAST, _MOST = 0.5, 4.0  # by which a picture's arm is thinner or thicker than those
_NEST_RADIUS_MM: Final = 8.0


def arm_pieces(
    robot: Robot, base: FramePlacement, nests_mm: FloatArray, joints_rad: FloatArray
) -> FloatArray:
    """Return links and tool in configurations.

    Parameters
    ----------
    robot : Robot
    base : FramePlacement
        In the world.
    nests_mm : (K, 3) array
        In the last frame [mm].
    joints_rad : (n, J) array

    Returns
    -------
    (n, m + K, 7) array
        Start, end and radius of the m links and of what leads from the flange to each nest, world [mm].
    """
    outline = arm_outline(robot, base)
    chain = chain_of(outline, joints_rad)
    links = arm_body(outline, chain)
    radii = _thickness(robot) * np.array(table_arm_radii_mm(robot.n_joints))[list(arm_links(outline))]
    arm = _pieces(links.start_mm, links.end_mm, radii)
    flange = np.broadcast_to(chain.points(np.zeros(3)), (len(nests_mm), len(joints_rad), 3))
    nests = np.array([chain.points(nest) for nest in nests_mm]).reshape(flange.shape)
    return np.concatenate([arm, _pieces(flange, nests, np.full(len(nests_mm), _NEST_RADIUS_MM))], axis=1)


def _thickness(robot: Robot) -> float:
    stretched = sum(abs(row.a_mm) + abs(row.d_mm) for row in robot.joints)
    return float(np.clip(stretched / _TABLE_REACH_MM, _LEAST, _MOST))


def _pieces(start_mm: FloatArray, end_mm: FloatArray, radius_mm: FloatArray) -> FloatArray:
    """Return capsules (m, n, 3) as rows of configurations, shape (n, m, 7)."""
    radius = np.broadcast_to(radius_mm[:, None, None], (*start_mm.shape[:2], 1))
    return np.concatenate([start_mm, end_mm, radius], axis=2).transpose(1, 0, 2)
