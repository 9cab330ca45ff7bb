"""Models of boxes of gauges that know their true values, and drivers on lines to them."""

from tests.contract.devices.gauges import Gauge
from truepose_drivers.contract.bench import messages
from truepose_drivers.keyence_gt2 import protocol as keyence
from truepose_drivers.keyence_gt2.driver import PLUGIN as KEYENCE
from truepose_drivers.keyence_gt2.driver import KeyenceUnit
from truepose_drivers.line_gauges.conversation import GaugeSettings, LineGauges
from truepose_drivers.line_gauges.protocol import Value
from truepose_drivers.mitutoyo_eh import protocol as eh
from truepose_drivers.mitutoyo_eh.driver import PLUGIN as MITUTOYO_EH
from truepose_drivers.mitutoyo_eh.driver import EhCounter
from truepose_drivers.mitutoyo_serial import protocol as serial
from truepose_drivers.mitutoyo_serial.driver import PLUGIN as MITUTOYO_SERIAL
from truepose_drivers.mitutoyo_serial.driver import MitutoyoBox

_MM_PER_INCH = 25.4


class Box(Gauge):
    """A box that answers lines, behind a terminal server that remembers."""

    specials = {"unit": "unit", "key": "foreign"}
    absent = {
        "another_serial_number_is_told": "a box tells no serial number, nor do the gauges on it",
        "a_frozen_device_gives_no_reading": "its answers have no count and no time stamp",
        "impossible_values_are_no_reading": "whatever its digits say, a gauge may mean",
    }
    dialect = None

    def __init__(self):
        super().__init__()
        self.inch = False

    def driver(self, wiring):
        line = wiring.line(self.answer, remembers=True)
        return LineGauges(line, wiring.clock, type(self).dialect(), GaugeSettings(range_mm=1.0))

    def answer(self, data):
        value = Value(self.true_mm / _MM_PER_INCH, 5) if self.inch else Value(self.true_mm, 4)
        return [self.say(value)]

    def move(self, rng):
        super().move(rng)
        self.inch = False

    def decoded(self, data):
        return messages(type(self).dialect().new_reader(), data)

    def special(self, name, wiring, rng):
        pressed = self.answer(b"")[0]  # what it shows when a key is pressed, before it moves on
        self.move(rng)
        if name == "unit":
            self.inch = True
        elif rng.integers(2):
            wiring.say(pressed)
        else:
            wiring.spoil = lambda said: [pressed, *said]


class MitutoyoLine(Box):
    """A Mitutoyo multiplexer."""

    plugin = MITUTOYO_SERIAL
    dialect = MitutoyoBox

    def say(self, value):
        return serial.encode(serial.ChannelValue(1, value))


class MitutoyoCounter(Box):
    """A Mitutoyo EH counter."""

    plugin = MITUTOYO_EH
    dialect = EhCounter

    def say(self, value):
        return eh.encode(eh.CounterValue(1, value), eh.ENDS["CR LF"])


class KeyenceAmplifiers(Box):
    """A Keyence unit with three amplifiers."""

    plugin = KEYENCE
    dialect = KeyenceUnit

    def say(self, value):
        others = keyence.Amplifier(Value(0.5, 4), keyence.GO)
        own = keyence.Amplifier(value, keyence.GO)
        return keyence.encode(keyence.Amplifiers("MS", (own, others, others)))
