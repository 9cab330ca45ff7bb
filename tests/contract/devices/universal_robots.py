"""Model of a Universal Robots controller on three lines: RTDE, script and dashboard."""

import math

from truepose_drivers.contract.bench import RobotBench, messages
from truepose_drivers.universal_robots.driver import PLUGIN, Ports, UniversalRobot
from truepose_drivers.universal_robots.protocol import (
    GREETING,
    Kind,
    PacketReader,
    Recipe,
    controller_version,
    encode,
    recipe_reply,
    text_message,
    verdict,
)
from truepose_drivers.universal_robots.script import INPUTS, OUTPUTS, robot_state

_PERIOD_S = 0.008
_STATES, _FOREIGN_STATES = Recipe(1, OUTPUTS), Recipe(2, OUTPUTS)
_REPLIES = {
    Kind.VERSION: verdict(Kind.VERSION, accepted=True),
    Kind.CONTROLLER: controller_version((5, 11, 0, 108249)),
    Kind.OUTPUTS: recipe_reply(Kind.OUTPUTS, 1, OUTPUTS.values()),
    Kind.INPUTS: recipe_reply(Kind.INPUTS, 1, INPUTS.values()),
    Kind.START: verdict(Kind.START, accepted=True),
    Kind.PAUSE: verdict(Kind.PAUSE, accepted=True),
}


class Universal(RobotBench):
    """A controller that streams its state while it is asked to."""

    plugin = PLUGIN
    specials = {
        "clock_stands": "frozen", "state_of_before": "stale", "foreign_recipe": "foreign",
        "message": "foreign", "nan": "nonsense",
    }  # fmt: skip
    absent = {"another_unit_changes_no_reading": "joints are in radians, and nothing changes that"}

    def __init__(self):
        super().__init__()
        self.time_s = 0.0
        self.streams = False

    def driver(self, wiring):
        rtde = wiring.line(self.answer, speaks=self.states, every_s=_PERIOD_S)
        dashboard = wiring.line(self.named, greets=lambda: [f"{GREETING}\n".encode()])
        return UniversalRobot(Ports(rtde, wiring.line(), dashboard), wiring.clock)

    def answer(self, data):
        packets, said = PacketReader(), []
        packets.receive_data(data)
        while (packet := packets.next_message()) is not None:
            self.streams = packet.kind is Kind.START
            said.append(encode(_REPLIES[packet.kind]))
        return said

    def named(self, data):
        names = {"get serial number": self.serial, "get robot model": "UR10"}
        return [f"{names[data.decode().strip()]}\n".encode()]

    def states(self):
        if not self.streams:
            return []
        if self.fault != "clock_stands":
            self.time_s += _PERIOD_S
        return [encode(_STATES.pack(self._state()))]

    def _state(self, **changes):
        zeros = {name: (0.0,) * (6 if kind == "VECTOR6D" else 1) for name, kind in OUTPUTS.items()}
        joints_rad = tuple(map(math.radians, self.joints_deg))
        return zeros | {"actual_q": joints_rad, "timestamp": (self.time_s,)} | changes

    def decoded(self, data):
        return messages(PacketReader(), data, _read)

    def special(self, name, wiring, rng):
        super().special(name, wiring, rng)
        elsewhere = {"actual_q": (1.0,) * 6}
        said = {
            "state_of_before": _STATES.pack(self._state(timestamp=(self.time_s - 1.0,), **elsewhere)),
            "foreign_recipe": _FOREIGN_STATES.pack(self._state(timestamp=(self.time_s + 1.0,), **elsewhere)),
            "message": text_message("joints at 1 1 1 1 1 1", "program", 3),
            "nan": _STATES.pack(self._state(actual_q=(math.nan,) * 6, timestamp=(self.time_s + 1.0,))),
        }
        if name in said:
            wiring.say(encode(said[name]))


def _read(packet):
    return robot_state(_STATES.unpack(packet.payload)) if packet.kind is Kind.DATA else packet
