"""Tables as other programs write them, of readings whose robot and units are known."""

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.kinematics.chain import nominal_chain


def readings(n=30, robot=IRB_120, joints=None):
    """Return joint angles [deg], nests and positions [mm] of a robot without errors."""
    joints = configurations(n, robot=robot) if joints is None else joints
    nest = 1 + np.arange(len(joints)) % len(NESTS)
    places = nominal_chain(robot, joints).points(np.array(NESTS)[nest - 1])
    return np.degrees(joints), nest, places


def table(names, rows, separator=",", decimal="."):
    """Return a table with these names above its columns."""
    cells = [[f"{value:.5f}".replace(".", decimal) for value in row] for row in rows]
    return "\n".join(separator.join(line) for line in [names, *cells]).encode()


def plain(n=30, **changes):
    """Return a table that says everything in plain words."""
    joints, nest, places = readings(n, **changes)
    names = ["pose", *(f"J{k} [deg]" for k in range(1, 7)), "nest", "x [mm]", "y [mm]", "z [mm]", "u [mm]"]
    return table(names, np.column_stack([np.arange(n), joints, nest, places, np.full(n, 0.02)]))
