"""Whether a model is of the robot that is to move by it."""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.results.identification import Model
from truepose.domain.robot import JointRow, Robot

_SAME_ROW: Final = 1e-6  # mm or rad: files round tables no further


def require_same_robot(model: Model, robot: Robot) -> None:
    """Raise ConfigurationError that says where a model's nominal robot is another one."""
    ours, theirs = model.robot.joints, robot.joints
    if len(ours) != len(theirs):
        raise ConfigurationError(
            f"The model has {len(ours)} joints, this robot {len(theirs)}: the model is of another one."
        )
    away = np.abs(_table(ours) - _table(theirs)).max(axis=1)
    if away.max() > _SAME_ROW:
        raise ConfigurationError(
            f"Row {int(np.argmax(away)) + 1} of the model's nominal table is not that of this cell's robot: "
            "the model is of another robot, or the table was changed since."
        )


def _table(joints: tuple[JointRow, ...]) -> FloatArray:
    return np.array([(row.alpha_rad, row.a_mm, row.theta_offset_rad, row.d_mm, row.sign) for row in joints])
