"""Models that know where they were measured."""

from dataclasses import replace

import numpy as np

from tests.helpers.identification.synthetic import configurations
from truepose.identification.model.validity import measured_zone


def zoned(model, n=60):
    """The model as if it had been measured at configurations spread over the calibration ranges."""
    robot = model.robot
    if robot.calibration_ranges is None:
        joints = np.random.default_rng(0).uniform(-1.5, 1.5, (n, robot.n_joints))
    else:
        joints = configurations(n, robot=robot)
    return replace(model, zone=measured_zone(robot, joints))
