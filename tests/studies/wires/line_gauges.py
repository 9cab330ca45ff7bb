"""Models of boxes of gauges that know their true values, and drivers on hostile wires to them."""

from tests.studies.wires.gauges import Gauge
from tests.studies.wires.hostile_link import HostileLink
from truepose_drivers.keyence_gt2 import protocol as keyence
from truepose_drivers.keyence_gt2.driver import KeyenceUnit
from truepose_drivers.line_gauges.dialogue import LineGauges
from truepose_drivers.line_gauges.settings import GaugeSettings
from truepose_drivers.line_gauges.value_form import Value
from truepose_drivers.mitutoyo_eh import protocol as eh
from truepose_drivers.mitutoyo_eh.driver import EhCounter
from truepose_drivers.mitutoyo_serial import protocol as serial
from truepose_drivers.mitutoyo_serial.driver import MitutoyoBox
from truepose_drivers.monotonic_clock import MonotonicClock

_MM_PER_INCH = 25.4


class Box(Gauge):
    """A box that answers lines, behind a terminal server that remembers."""

    kind = "linear_gauge"
    dialect = None

    def __init__(self):
        super().__init__()
        self.inch = False
        self.link = HostileLink(self.answer, remembers=True)
        self.driver = LineGauges(
            self.link, MonotonicClock(), type(self).dialect(), GaugeSettings(range_mm=1.0)
        )
        self.specials = ("unit", "key")

    def answer(self, data):
        value = Value(self.true_mm / _MM_PER_INCH, 5) if self.inch else Value(self.true_mm, 4)
        return [self.say(value)]

    def move(self, rng):
        super().move(rng)
        self.inch = False

    def special(self, name, rng):
        pressed = self.answer(b"")[0]  # what it shows when a key is pressed, before it moves on
        self.move(rng)
        if name == "unit":
            self.inch = True
        elif rng.integers(2):
            self.link.pieces.append(pressed)
        else:
            self.link.spoil = lambda said: [pressed, *said]


class MitutoyoLine(Box):
    """A Mitutoyo multiplexer."""

    dialect = MitutoyoBox

    def say(self, value):
        return serial.encode(serial.ChannelValue(1, value))


class MitutoyoCounter(Box):
    """A Mitutoyo EH counter."""

    dialect = EhCounter

    def say(self, value):
        return eh.encode(eh.Counted(1, value), eh.ENDS["CR LF"])


class KeyenceAmplifiers(Box):
    """A Keyence unit with three amplifiers."""

    dialect = KeyenceUnit

    def say(self, value):
        others = keyence.Amplifier(Value(0.5, 4), keyence.GO)
        own = keyence.Amplifier(value, keyence.GO)
        return keyence.encode(keyence.Amplifiers("MS", (own, others, others)))
