"""Models of a robot's controller, a cell's clock and its hands on hostile wires."""

import json

from tests.contract.devices.watched_robot import ABSENT, IRB_120_RANGES_DEG, WatchedRobot
from truepose_drivers.abb_open_abb.driver import PLUGIN as OPEN_ABB
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot
from truepose_drivers.abb_open_abb.protocol import (
    Code,
    Reply,
    ReplyStatus,
    decode_reply,
    decode_request,
    encode_reply,
    joint_angles_deg,
    rapid_number,
)
from truepose_drivers.cell_clock.driver import PLUGIN as CELL_CLOCK
from truepose_drivers.cell_clock.driver import CellClock
from truepose_drivers.cell_clock.protocol import decode_answer as decode_time
from truepose_drivers.cell_hands.driver import PLUGIN as CELL_HANDS
from truepose_drivers.cell_hands.driver import CellHands
from truepose_drivers.cell_hands.protocol import decode_answer as decode_deed
from truepose_drivers.contract.bench import Bench, messages
from truepose_drivers.errors import DeviceRefusedError
from truepose_drivers.framing import LineReader
from truepose_drivers.guard import guarded


class Controller(WatchedRobot):
    """An IRC5 with open_abb."""

    plugin = OPEN_ABB
    ranges_deg = IRB_120_RANGES_DEG
    specials = {
        "wrong_id": "foreign", "nan": "nonsense", "huge_angle": "nonsense", "seven_joints": "nonsense",
        "five_joints": "nonsense",
    }  # fmt: skip
    absent = {
        **ABSENT,
        "a_frozen_device_gives_no_reading": "its replies have no count and no time stamp",
    }

    def driver(self, wiring):
        return OpenAbbRobot(wiring.line(self.answer), wiring.clock)

    def move(self, rng):
        self.decimals = int(rng.choice([0, 1, 2, 2]))
        super().move(rng)

    def answer(self, data):
        code = decode_request(data).code
        if code == Code.CLOSE:
            return []
        text = {
            Code.GET_JOINTS: " ".join(rapid_number(angle, 2) for angle in self.joints_deg),
            Code.CONTROLLER_INFO: f"{self.serial}*6.08.01*IRB 120",
        }.get(code, "")
        return [encode_reply(Reply(code, ReplyStatus.OK, text))]

    def decoded(self, data):
        return [joint_angles_deg(decode_reply(data), 6)]

    def special(self, name, wiring, rng):
        said = {
            "wrong_id": b"3 1 300.00 0.00 500.00 0.000 0.707 0.000",
            "nan": b"4 1 10.00 nan 30.00 0.00 45.00 -0.01",
            "huge_angle": b"4 1 10.00 9E+09 30.00 0.00 45.00 -0.01",
            "seven_joints": b"4 1 10.00 20.00 30.00 0.00 45.00 -0.01 7.00",
            "five_joints": b"4 1 10.00 20.00 30.00 0.00 45.01",
        }[name]
        wiring.spoil = lambda _: [said]


class ClockOfCell(Bench):
    """The clock of a simulated cell; connects by itself."""

    plugin = CELL_CLOCK
    free_numbers = True
    specials = {"back": "nonsense", "nan": "nonsense", "huge_number": "nonsense"}
    absent = {
        "another_unit_changes_no_reading": "a clock counts seconds",
        "a_frozen_device_gives_no_reading": "a cell that nobody lets move on stands still",
        "answers_to_others_are_no_reading": "it has one answer",
    }

    def __init__(self):
        super().__init__()
        self.time_s = 0.0

    def watched(self, device):
        return guarded("cell_clock", "clock", device)  # which sees a clock that runs back

    def driver(self, wiring):
        return CellClock(lambda: wiring.line(self.answer), answer_timeout_s=1.0)

    def move(self, rng):
        self.time_s += float(rng.uniform(0.1, 100.0))

    def answer(self, data):
        return [json.dumps({"now_s": self.time_s}).encode() + b"\n"]

    def decoded(self, data):
        return messages(LineReader(), data, decode_time)

    def special(self, name, wiring, rng):
        said = {
            "back": b'{"now_s": -5.0}\n',
            "nan": b'{"now_s": NaN}\n',
            "huge_number": b'{"now_s": 1e999}\n',
        }
        wiring.spoil = lambda _: [said[name]]

    async def ask(self, device):
        return await device.now_s()

    def is_right(self, now_s):
        return now_s == self.time_s


class HandsOfPerson(Bench):
    """The hands of a simulated cell: every second deed is refused."""

    plugin = CELL_HANDS
    specials = {"nothing_said": "nonsense", "a_number": "nonsense"}
    absent = {
        "another_unit_changes_no_reading": "hands do, and measure nothing",
        "a_frozen_device_gives_no_reading": "hands do, and measure nothing",
        "answers_to_others_are_no_reading": "hands have one answer",
        "another_serial_number_is_told": "a person has no serial number",
    }

    def __init__(self):
        super().__init__()
        self.refuses = False

    def driver(self, wiring):
        return CellHands(wiring.line(self.answer), answer_timeout_s=1.0)

    def move(self, rng):
        self.refuses = not self.refuses

    def answer(self, data):
        return [b'{"error": "no"}\n' if self.refuses else b'{"ok": true}\n']

    def decoded(self, data):
        return messages(LineReader(), data, decode_deed)

    def special(self, name, wiring, rng):
        wiring.spoil = lambda _: [b"{}\n" if name == "nothing_said" else b"1\n"]

    async def ask(self, device):
        try:
            await device.do("connect", {"base": 1, "tool": 1})
        except DeviceRefusedError as error:
            return type(error) is DeviceRefusedError
        return False

    def is_right(self, refused):
        return refused == self.refuses
