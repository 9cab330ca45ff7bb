"""Model of a FANUC controller with our own MAPPDK server on a hostile wire."""

from tests.contract.devices.watched_robot import ABSENT, FANUC_RANGES_DEG, WatchedRobot
from truepose_drivers.arm_options import JointCounting
from truepose_drivers.fanuc_mappdk.driver import PLUGIN, MappdkRobot
from truepose_drivers.fanuc_mappdk.protocol import (
    GREETING,
    Command,
    Reply,
    ReplyCode,
    decode_reply,
    decode_request,
    encode_identity,
    encode_joints,
    encode_reply,
    joint_angles_deg,
)


class Fanuc(WatchedRobot):
    """A controller that shows joint 3 from the horizontal."""

    plugin = PLUGIN
    ranges_deg = FANUC_RANGES_DEG
    specials = {
        "pose": "foreign", "success": "foreign", "nan": "nonsense", "huge_angle": "nonsense",
        "seven_joints": "nonsense", "five_joints": "nonsense",
    }  # fmt: skip
    absent = {
        **ABSENT,
        "a_frozen_device_gives_no_reading": "its replies have no count and no time stamp",
    }

    def driver(self, wiring):
        link = wiring.line(self.answer, greets=lambda: [encode_reply(GREETING)])
        return MappdkRobot(link, wiring.clock)

    def answer(self, data):
        if decode_request(data.decode().strip()).name == Command.JOINTS:
            return [encode_reply(encode_joints(JointCounting().of_controller(self.joints_deg)))]
        if decode_request(data.decode().strip()).name == Command.IDENTITY:
            return [encode_reply(encode_identity("LR Mate 200iC", self.serial, "V7.70"))]
        return [encode_reply(Reply(ReplyCode.ERROR, "wrong-command"))]

    def decoded(self, data):
        return [joint_angles_deg(decode_reply(data))]

    def special(self, name, wiring, rng):
        said = encode_reply(encode_joints((10.0, 20.0, 30.0, 40.0, 50.0, 60.0)))
        bad = {
            "pose": b"0:x= 300.000,y=   0.000,z= 500.000,w=   0.000,p=   0.000,r=   0.000",
            "success": encode_reply(GREETING),
            "nan": said.replace(b"20.000", b"nan"),
            "huge_angle": said.replace(b"20.000", b"90000.000"),
            "seven_joints": said.replace(b"none", b"   7.000", 1),
            "five_joints": said.replace(b"  60.000", b"none"),
        }[name]
        wiring.spoil = lambda _: [bad]
