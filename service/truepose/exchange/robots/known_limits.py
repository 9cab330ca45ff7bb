"""Joint limits of robots that ship, for a model that was made without them.

Campaigns do not state limits. A robot whose name has that of a shipped one in it ("ABB IRB 120, cell 4"), and
whose table of joints is the same, has the limits that its maker publishes.
"""

from dataclasses import replace
from functools import cache
from typing import Final

import numpy as np

from truepose.domain.results.identification import Model
from truepose.domain.robot import Robot
from truepose.exchange.robots.shipped import list_robots, load_robot

_ROUNDING: Final = 1e-6  # of a file, in mm and rad


def with_known_limits(model: Model) -> Model:
    """Return a model whose robot has its published limits, if it says none and they are known."""
    if model.robot.joint_limits is not None:
        return model
    found = next((known for known in _known() if _same(model.robot, known)), None)
    return (
        model
        if found is None
        else replace(model, robot=replace(model.robot, joint_limits=found.joint_limits))
    )


@cache
def _known() -> tuple[Robot, ...]:
    return tuple(load_robot(name) for name in list_robots())


def _same(robot: Robot, known: Robot) -> bool:
    """Whether a robot has the name and the table of a known one."""
    if _plain(known.name) not in _plain(robot.name) or robot.n_joints != known.n_joints:
        return False
    return bool(np.allclose(_table(robot), _table(known), rtol=0.0, atol=_ROUNDING))


def _plain(name: str) -> str:
    return "".join(filter(str.isalnum, name.casefold()))


def _table(robot: Robot) -> list[tuple[float, ...]]:
    return [
        (row.alpha_rad, row.a_mm, row.theta_offset_rad, row.d_mm, row.beta_rad, row.sign)
        for row in robot.joints
    ]
