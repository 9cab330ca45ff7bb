"""Model of a FANUC controller with the Remote Motion Interface on a hostile wire."""

import json
import math

from tests.contract.devices.watched_robot import ABSENT, FANUC_RANGES_DEG, WatchedRobot
from truepose_drivers.arm_options import JointCounting
from truepose_drivers.contract.bench import messages
from truepose_drivers.fanuc_rmi.driver import PLUGIN, RmiRobot
from truepose_drivers.fanuc_rmi.protocol import (
    PacketReader,
    Status,
    decode,
    decode_axes,
    decode_status,
    encode,
    encode_axes,
    encode_status,
    handed_over,
    reply,
)

_STATUS = Status(True, False, True, False, 1, 100)
_ELSEWHERE_DEG = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)


class FanucRmi(WatchedRobot):
    """A controller that shows joint 3 from the horizontal, and both of its ports."""

    plugin = PLUGIN
    ranges_deg = FANUC_RANGES_DEG
    specials = {
        "clock_stands": "frozen", "joints_of_before": "stale", "position": "foreign",
        "other_command": "foreign", "end_of_motion": "foreign", "nan": "nonsense",
        "huge_angle": "nonsense", "five_joints": "nonsense", "axis_twice": "nonsense",
    }  # fmt: skip
    absent = {
        **ABSENT,
        "another_serial_number_is_told": "the interface tells no serial number",
    }

    def __init__(self):
        super().__init__()
        self.time_ms = 1000

    def driver(self, wiring):
        return RmiRobot(lambda port: wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        return [encode(reply(request, fields=self._fields(request.name))) for request in _requests(data)]

    def _fields(self, name):
        match name:
            case "FRC_Connect":
                return {"PortNumber": 16002, "MajorVersion": 9, "MinorVersion": 0}
            case "FRC_GetStatus":
                return encode_status(_STATUS)
            case "FRC_ReadJointAngles":
                self.time_ms += self.fault != "clock_stands"
                return self._axes(JointCounting().of_controller(self.joints_deg), self.time_ms)
        return {}

    def _axes(self, angles_deg, time_ms):
        axes = encode_axes([*(round(angle, 3) for angle in angles_deg), 0.0, 0.0, 0.0])
        return {"TimeTag": time_ms, "JointAngle": axes}

    def decoded(self, data):
        return messages(PacketReader(), data, _read)

    def special(self, name, wiring, rng):
        super().special(name, wiring, rng)
        if name == "clock_stands":
            return
        said = {
            "Command": "FRC_ReadJointAngles",
            "ErrorID": 0,
            **self._axes(_ELSEWHERE_DEG, self.time_ms + 5),
        }
        axes = said["JointAngle"]
        bad = {
            "joints_of_before": said | {"TimeTag": self.time_ms - 5},
            "position": {"Command": "FRC_ReadCartesianPosition", "ErrorID": 0, "Position": {"X": 1.0}},
            "other_command": said | {"Command": "FRC_ReadJointSpeeds"},
            "end_of_motion": {"Instruction": "FRC_JointMotionJRep", "ErrorID": 0, "SequenceID": 3},
            "nan": said | {"JointAngle": axes | {"J2": math.nan}},
            "huge_angle": said | {"JointAngle": axes | {"J2": 90_000.0}},
            "five_joints": said | {"JointAngle": {f"J{joint}": 1.0 for joint in range(1, 6)}},
            "axis_twice": said,
        }[name]
        line = json.dumps(bad).encode() + b"\r\n"
        if name == "axis_twice":
            line = line.replace(b'"J2"', b'"J1"')
        wiring.spoil = lambda _: [line]


def _requests(data):
    return [decode(line) for line in data.splitlines()]


def _read(packet):
    readers = {"FRC_Connect": handed_over, "FRC_GetStatus": decode_status, "FRC_ReadJointAngles": decode_axes}
    return readers.get(packet.name, lambda other: other)(packet)
