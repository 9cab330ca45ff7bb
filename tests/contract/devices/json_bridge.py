"""A model of a shop's bridge to a tracker of points and poses."""

from dataclasses import replace

from truepose_drivers.contract.bench import PoseTrackerBench, TrackerBench, messages
from truepose_drivers.framing import LineReader
from truepose_drivers.json_bridge.driver import PLUGIN, BridgedTracker, point_of, pose_of
from truepose_drivers.json_bridge.protocol import Answer, decode_question, decode_reply, encode_reply

MM_PER_INCH = 25.4


class _Bridge:
    """Answers as its instrument is; counts its measurements."""

    tolerance_mm = 1e-6
    free_numbers = True
    specials = {
        "inches": "unit", "no_unit": "unit", "frozen": "frozen", "back": "stale", "other_question": "stale",
        "another_instrument": "foreign", "nan": "nonsense", "two_numbers": "nonsense", "no_count": "nonsense",
    }  # fmt: skip

    def __init__(self):
        super().__init__()
        self.number = 0
        self.last = {}

    def driver(self, wiring):
        return BridgedTracker(wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        return [encode_reply(self._reply(decode_question(line))) for line in data.splitlines()]

    def decoded(self, data):
        return messages(LineReader(), data, lambda line: self.read(decode_reply(line)))

    def _reply(self, question):
        values = {
            "hello": {"version": 1, "manufacturer": "FARO", "model": "Vantage", "firmware": "6"},
            "initialise": {"sequence": self.number},
        }.get(question.ask, {})
        if question.ask.startswith("measure"):
            self.number += 1
            values = self._spoilt(self.measured())
        number = question.number - (self.fault == "other_question" and question.number > 1)
        serial = "9999" if self.fault == "another_instrument" and "unit" in values else self.serial
        return Answer(number, serial, values)

    def _spoilt(self, good):
        first, before = good[self.key], self.last
        values = {"unit": "mm", "sequence": self.number, **good}
        match self.fault:
            case "inches":
                values = {**values, "unit": "inch", self.key: [value / MM_PER_INCH for value in first]}
            case "no_unit":
                values = {key: value for key, value in values.items() if key != "unit"}
            case "frozen" | "back" if before:
                values = {**before, self.key: [1.0, 2.0, 3.0]}
                values["sequence"] -= self.fault == "back"
            case "nan":
                values = {**values, self.key: [first[0], "NaN", first[2]]}
            case "two_numbers":
                values = {**values, self.key: first[:2]}
            case "no_count":
                values = {**values, "sequence": None}
            case _:
                self.last = values
        return values


class PointBridge(_Bridge, TrackerBench):
    """To a tracker of points."""

    plugin = PLUGIN
    key = "point_mm"

    def read(self, reply):
        return point_of(reply.values) if isinstance(reply, Answer) and self.key in reply.values else reply

    def measured(self):
        return {"point_mm": list(self.point_mm), "rms_mm": 0.01}


class PoseBridge(_Bridge, PoseTrackerBench):
    """To a tracker of poses."""

    plugin = replace(PLUGIN, kind="pose_tracker", also=())
    key = "position_mm"

    def read(self, reply):
        return pose_of(reply.values) if isinstance(reply, Answer) and self.key in reply.values else reply

    def measured(self):
        return {"position_mm": list(self.position_mm), "quaternion": [0.5, -0.5, 0.5, 0.5]}
