"""Joint 3 counted from the horizontal, as controllers of FANUC show and print it, and from the upper arm.

A forearm keeps its inclination while joint 2 alone moves on such a controller. With axes 2 and 3 parallel,
the inclination is s_2 q_2 + w s_3 q_3, s the signs of the joints and w = 1 where both axes point the same
way, hence

    J3 = q_3 + k q_2,   k = w s_2 s_3

Only this is known of it: that the controller's J3 has the sign of the table's joint 3 is for the user to say.

Sources: ros-industrial/fanuc, issue 186 and fanuc_experimental, issue 17 (J2-J3 coupling); checked by the
joints and poses of an R-2000iB/165F in onerobotics.com, The perils of six-axis robots, 2013.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from truepose.domain.robot import Robot
from truepose.exchange.programs.program import Configuration, Program

_PARALLEL: Final = 1e-9  # sine of the angle between axes 2 and 3


def can_be_coupled(robot: Robot) -> bool:
    """Whether joint 3 of an arm can be counted from the horizontal: axes 2 and 3 are parallel."""
    return robot.n_joints > 2 and abs(np.sin(robot.joints[2].alpha_rad)) < _PARALLEL


def from_upper_arm(robot: Robot, shown: Configuration) -> Configuration:
    """Return the joints of the model of a configuration that the controller shows."""
    return _turned(robot, shown, -1.0)


def from_horizontal(robot: Robot, joints: Configuration) -> Configuration:
    """Return what the controller shows of joints of the model."""
    return _turned(robot, joints, 1.0)


def uncoupled(robot: Robot, program: Program) -> Program:
    """Return a program whose configurations are those of the model."""
    targets = (
        replace(target, value=from_upper_arm(robot, target.value))
        if isinstance(target.value, Configuration)
        else target
        for target in program.targets
    )
    return replace(program, targets=tuple(targets))


def _turned(robot: Robot, joints: Configuration, way: float) -> Configuration:
    upper, elbow = robot.joints[1:3]
    share = way * float(np.sign(np.cos(elbow.alpha_rad))) * upper.sign * elbow.sign
    first, second, third, *others = joints.joints_rad
    return Configuration((first, second, third + share * second, *others))
