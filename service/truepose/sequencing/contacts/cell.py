"""What a session of closed loops knows of the cell it runs in."""

from dataclasses import dataclass, field

from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose_drivers.api import Clock, FullGauge, FullRobot, MotionLimits


@dataclass(frozen=True, slots=True)
class GaugeBox:
    """A gauge, or a box of several, and what the cell file says of it."""

    name: str
    gauge: FullGauge
    serial: str = ""  # that it must tell, where it tells one


@dataclass(frozen=True, slots=True)
class ContactCell:
    """Devices and nominal robot of one cell."""

    gauges: tuple[GaugeBox, ...]  # in the order in which the targets of a stop are read
    robot_controller: FullRobot
    clock: Clock
    robot: Robot
    base: FramePlacement = field(default_factory=FramePlacement)  # nominal, in the world
    joint_limits: tuple[JointRange, ...] | None = None  # what no motion may leave
    speed_limits: MotionLimits | None = None  # above which nothing moves, whatever the plan says
    attachment: int = 1  # how often the tool has been mounted
    robot_serial: str = ""
