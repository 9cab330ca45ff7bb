"""A bench of a robot that is used as the service does: within the ranges of its joints."""

import math

from truepose.domain.robot import JointRange
from truepose.sessions.engine.robot import WatchfulRobot
from truepose_drivers.contract.bench import RobotBench

ABSENT = {"another_unit_changes_no_reading": "joints are in degrees, and nothing changes that"}
FANUC_RANGES_DEG = ((-170, 170), (-60, 140), (-194, 194), (-190, 190), (-120, 120), (-360, 360))
IRB_120_RANGES_DEG = ((-165, 165), (-110, 110), (-110, 70), (-160, 160), (-120, 120), (-400, 400))


class WatchedRobot(RobotBench):
    """A robot in degrees, whose stated joints must be within its ranges."""

    decimals = 3
    free_numbers = True

    def watched(self, device):
        ranges = (JointRange(math.radians(low), math.radians(high)) for low, high in self.ranges_deg)
        return WatchfulRobot(device, tuple(ranges))
