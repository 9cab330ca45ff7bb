"""What a ballbar session knows of the cell it runs in."""

from dataclasses import dataclass, field

from truepose.domain.robot import JointRange, Robot
from truepose.sequencing.engine.identity.check import Expected
from truepose_drivers.api import Ballbar, Clock, FullRobot, MotionLimits


@dataclass(frozen=True, slots=True)
class BallbarCell:
    """Devices and nominal robot of one cell."""

    ballbar: Ballbar
    robot_controller: FullRobot
    clock: Clock
    robot: Robot
    joint_limits: tuple[JointRange, ...] | None = None  # what no motion may leave
    speed_limits: MotionLimits | None = None  # above which nothing moves, whatever the plan says
    expected: Expected = field(default_factory=Expected)  # which devices must answer
    ballbar_device_serial: str = ""  # of the device entry that the session was planned with
