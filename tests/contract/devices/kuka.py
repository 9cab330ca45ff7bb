"""Model of a KUKA controller behind a variable proxy on a hostile wire."""

import struct

from tests.contract.devices.watched_robot import ABSENT, WatchedRobot
from truepose_drivers.contract.bench import messages
from truepose_drivers.kuka_variable_proxy.driver import PLUGIN, KukaRobot
from truepose_drivers.kuka_variable_proxy.protocol import (
    NUMBERS,
    Answer,
    AnswerReader,
    Mode,
    RequestReader,
    decode_axes,
    decode_text,
    encode_answer,
    encode_axes,
)

_RANGES_DEG = ((-170, 170), (-190, 45), (-120, 156), (-185, 185), (-120, 120), (-350, 350))
_ELSEWHERE_DEG = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0)


class Kuka(WatchedRobot):
    """A controller that counts as the robot file does."""

    plugin = PLUGIN
    ranges_deg = _RANGES_DEG
    tolerance_deg = 2.0**-15
    specials = {
        "number_of_before": "stale", "number_of_after": "foreign", "was_written": "foreign",
        "position": "foreign", "nan": "nonsense", "huge_angle": "nonsense", "five_axes": "nonsense",
        "not_read": "nonsense", "endless": "nonsense",
    }  # fmt: skip
    absent = {
        **ABSENT,
        "a_frozen_device_gives_no_reading": "answers bear the number of their request, and no time",
    }

    def driver(self, wiring):
        return KukaRobot(wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        reader, said = RequestReader(), []
        reader.receive_data(data)
        while (request := reader.next_message()) is not None:
            said.append(encode_answer(Answer(request.number, Mode.READ, self._value(request.name), True)))
        return said

    def decoded(self, data):
        return messages(AnswerReader(), data, _read)

    def _value(self, name):
        shown = encode_axes((*self.joints_deg, *(0.0,) * 6), "E6AXIS")
        return {"$AXIS_ACT": shown, "PING": "PONG", "$KR_SERIALNO": self.serial}.get(name, "")

    def special(self, name, wiring, rng):
        def bad(said):
            (number,) = struct.unpack_from(">H", said[0])
            axes = encode_axes((*_ELSEWHERE_DEG, *(0.0,) * 6), "E6AXIS")
            answer = Answer(number, Mode.READ, axes, True)
            spoilt = {
                "number_of_before": Answer((number - 1) % NUMBERS, Mode.READ, axes, True),
                "number_of_after": Answer((number + 1) % NUMBERS, Mode.READ, axes, True),
                "was_written": Answer(number, Mode.WRITE, axes, True),
                "position": Answer(number, Mode.READ, "{E6POS: X 1.0, Y 2.0, Z 3.0}", True),
                "nan": Answer(number, Mode.READ, axes.replace("A2 20.0", "A2 nan"), True),
                "huge_angle": Answer(number, Mode.READ, axes.replace("A2 20.0", "A2 90000.0"), True),
                "five_axes": Answer(number, Mode.READ, axes.replace("A6 60.0, ", ""), True),
                "not_read": Answer(number, Mode.READ, "", False),
            }
            return [encode_answer(spoilt[name]) if name in spoilt else encode_answer(answer)[:-1] + b"\x07"]

        wiring.spoil = bad


def _read(answer):
    return (decode_axes if answer.value.startswith("{") else decode_text)(answer.value)
