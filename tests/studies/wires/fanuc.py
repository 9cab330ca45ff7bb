"""Model of a FANUC controller with a stock MAPPDK server on a hostile wire."""

import math

import numpy as np

from tests.studies.wires.hostile_link import HostileLink
from tests.studies.wires.machines import Machine
from truepose.domain.robot import JointRange
from truepose.sequencing.engine.motion.plausible_robot import WatchfulRobot
from truepose_drivers.fanuc_mappdk.driver import MappdkRobot, TimeOuts
from truepose_drivers.fanuc_mappdk.joint_counting import JointCounting
from truepose_drivers.fanuc_mappdk.protocol import (
    GREETING,
    Command,
    Reply,
    ReplyCode,
    decode_request,
    encode_joints,
    encode_reply,
)
from truepose_drivers.monotonic_clock import MonotonicClock

_RANGES = tuple(
    JointRange(math.radians(low), math.radians(high))
    for low, high in ((-170, 170), (-60, 140), (-194, 194), (-190, 190), (-120, 120), (-360, 360))
)


class GreetingLink(HostileLink):
    """A wire to a server that speaks first."""

    async def open(self):
        await super().open()
        self.pieces.extend(self._spoiled([encode_reply(GREETING)]))


class Fanuc(Machine):
    """A controller that shows joint 3 from the horizontal."""

    kind = "robot"
    free_numbers = True

    def __init__(self):
        self.joints_deg = (0.0,) * 6
        self.link = GreetingLink(self.answer)
        quick = TimeOuts(connect_s=0.0, retry_s=0.0)
        self.driver = MappdkRobot(self.link, MonotonicClock(), time_outs=quick)
        self.specials = ("pose", "success", "nan", "huge_angle", "seven_joints", "five_joints")

    def watched(self, device):
        return WatchfulRobot(device, _RANGES)

    def move(self, rng):
        angles = [rng.uniform(math.degrees(own.lower_rad), math.degrees(own.upper_rad)) for own in _RANGES]
        self.joints_deg = tuple(round(float(angle), 3) for angle in angles)

    def answer(self, data):
        if decode_request(data.decode().strip()).name == Command.JOINTS:
            return [encode_reply(encode_joints(JointCounting().of_controller(self.joints_deg)))]
        return [encode_reply(Reply(ReplyCode.ERROR, "wrong-command"))]

    def special(self, name, rng):
        said = encode_reply(encode_joints((10.0, 20.0, 30.0, 40.0, 50.0, 60.0)))
        bad = {
            "pose": b"0:x= 300.000,y=   0.000,z= 500.000,w=   0.000,p=   0.000,r=   0.000",
            "success": encode_reply(GREETING),
            "nan": said.replace(b"20.000", b"nan"),
            "huge_angle": said.replace(b"20.000", b"90000.000"),
            "seven_joints": said.replace(b"none", b"   7.000", 1),
            "five_joints": said.replace(b"  60.000", b"none"),
        }[name]
        self.link.spoil = lambda _: [bad]

    async def ask(self, device):
        return np.degrees((await device.read_joints()).joints_rad)

    def is_right(self, joints_deg):
        return bool(np.allclose(joints_deg, self.joints_deg, rtol=0.0, atol=1e-6))
