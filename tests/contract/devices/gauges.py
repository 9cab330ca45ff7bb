"""Models of ballbars that know their true deviation, and drivers on hostile wires to them."""

import math
from dataclasses import replace

from tests.contract.devices.usb_plug import UsbPlug
from truepose.sessions.ballbar.live import live_state
from truepose_drivers.ballbar_bridge.driver import PLUGIN as BRIDGE
from truepose_drivers.ballbar_bridge.driver import BridgedBallbar
from truepose_drivers.ballbar_bridge.protocol import BridgeReading, Hello, decode
from truepose_drivers.ballbar_bridge.protocol import encode as encode_line
from truepose_drivers.ballbar_hid.driver import PLUGIN as HID
from truepose_drivers.ballbar_hid.driver import HidBallbar
from truepose_drivers.ballbar_hid.protocol import (
    BarIdentity,
    BarReading,
    Status,
    decode_reading,
    encode_bar,
    encode_reading,
)
from truepose_drivers.contract.bench import BallbarBench, messages
from truepose_drivers.contract.wire import Silence
from truepose_drivers.framing import LineReader
from truepose_drivers.heidenhain_nd.driver import PLUGIN as ND
from truepose_drivers.heidenhain_nd.driver import HeidenhainCounter
from truepose_drivers.heidenhain_nd.protocol import (
    COUNTS_PER_INCH,
    COUNTS_PER_MM,
    MM_PER_INCH,
    Lamps,
    Refusal,
    ReplyReader,
    RequestReader,
    encode_reply,
    identity_lines,
    lamps_line,
    printed_line,
    value_line,
)
from truepose_drivers.line_gauges.protocol import Value
from truepose_drivers.mitutoyo_usb_itn.driver import PLUGIN as USB_ITN
from truepose_drivers.mitutoyo_usb_itn.driver import UsbItnGauge
from truepose_drivers.mitutoyo_usb_itn.protocol import DeviceInfo, encode
from truepose_drivers.mitutoyo_usb_itn.protocol import ReplyReader as UsbItnReader

_TOLERANCE_MM = 2e-4  # a step of an inch display
_RANGE_MM = 1.0


class Gauge(BallbarBench):
    """What the service would take for a length is judged; an inch display has coarser steps."""

    async def ask(self, device):
        reading = await device.read()
        usable = live_state(reading, None, _RANGE_MM, unsteady=False) == "in_range"
        return reading.deviation_mm if usable else None

    def is_right(self, deviation_mm):
        return math.isfinite(deviation_mm) and abs(deviation_mm - self.true_mm) <= _TOLERANCE_MM


class Counter(Gauge):
    """A Heidenhain ND, behind a terminal server that remembers."""

    plugin = ND
    specials = {"unit": "unit", "print": "foreign", "nothing_but_prints": "foreign"}
    absent = {
        "another_serial_number_is_told": "the counter tells model and software, and no serial number",
        "a_frozen_device_gives_no_reading": "its answers have no count and no time stamp",
        "impossible_values_are_no_reading": "whatever seven digits say, a gauge may mean",
    }

    def __init__(self):
        super().__init__()
        self.inch = False
        self.unit_changes = 0  # commands from now until somebody presses the key for the unit

    def driver(self, wiring):
        return HeidenhainCounter(wiring.line(self.answer, remembers=True), wiring.clock)

    def answer(self, data):
        requests, said = RequestReader(), []
        requests.receive_data(data)
        while (request := requests.next_message()) is not None:
            self.unit_changes -= 1
            if self.unit_changes == 0:
                self.inch = not self.inch
            said.append(b"".join(map(encode_reply, self._replies(request.code))))
        return said

    def _replies(self, code):
        counts = self.true_mm / MM_PER_INCH * COUNTS_PER_INCH if self.inch else self.true_mm * COUNTS_PER_MM
        return {
            "A0000": identity_lines("ND-287", "349797-04", "2001-05-04"),
            "A0301": (Refusal(),),
            "A0200": (value_line(round(counts)),),
            "A0800": (lamps_line(Lamps(inch=self.inch, inside=True)),),
        }[code]

    def decoded(self, data):
        return messages(ReplyReader(), data)

    def special(self, name, wiring, rng):
        printed = encode_reply(printed_line(int(rng.integers(-9999, 9999)), Lamps(inside=True)))
        if name == "unit":
            self.unit_changes = int(rng.integers(1, 8))
        elif name == "print":
            before = bool(rng.integers(2))
            wiring.say(printed)
            wiring.spoil = lambda said: [printed, *said] if before else [*said, printed]
        else:
            wiring.spoil = lambda said: [printed] * 50 + [Silence()]


class Cable(Gauge):
    """A Mitutoyo USB-ITN, whose packets wait until they are fetched."""

    plugin = USB_ITN
    specials = {"unit": "unit", "button": "foreign", "half_button": "foreign"}
    absent = {
        "a_frozen_device_gives_no_reading": "its values have no count and no time stamp",
        "impossible_values_are_no_reading": "whatever its digits say, a gauge may mean",
    }

    def __init__(self):
        super().__init__()
        self.inch = False

    def driver(self, wiring):
        return UsbItnGauge(UsbPlug(wiring, wiring.line(self.answer, remembers=True), self), wiring.clock)

    def answer(self, data):
        return [encode(DeviceInfo("V2") if data == b"V\r" else self._value())]

    def _value(self):
        if self.inch:
            return Value(self.true_mm / MM_PER_INCH, 5)
        return Value(self.true_mm, 4)

    def move(self, rng):
        super().move(rng)
        self.inch = False

    def decoded(self, data):
        return messages(UsbItnReader(), data)

    def special(self, name, wiring, rng):
        pressed = encode(self._value())  # what it shows when the button is pressed, before it moves on
        self.move(rng)
        if name == "unit":
            self.inch = True
        elif name == "button":
            wiring.say(pressed)
        else:
            place = int(rng.integers(1, len(pressed)))
            wiring.say(pressed[:place])
            wiring.spoil = lambda said: [pressed[place:], *said]


class Bar(Gauge):
    """A HID ballbar."""

    plugin = HID
    specials = {"frozen": "frozen", "back": "stale", "inch": "nonsense", "lost_zero": "nonsense"}
    absent = {
        "another_unit_changes_no_reading": "a report has tenths of micrometres and no other unit",
        "answers_to_others_are_no_reading": "a HID device has one report, and one program that listens",
        "a_device_that_hangs_up_at_once_was_not_connected": "who is there is told beside the reports",
        "connect_refuses_another_protocol": "the system chooses a device by its vendor and product",
        "answers_in_single_bytes_are_right": "the system hands out whole reports",
        "answers_that_stall_are_waited_for": "the system hands out whole reports",
    }

    def __init__(self):
        super().__init__()
        self.number = 0
        self.change = None

    def driver(self, wiring):
        return HidBallbar(_HidPort(wiring, wiring.line(speaks=self._reports), self), wiring.clock)

    def _reports(self):
        self.number += 1
        report = BarReading(self.true_mm, False, Status(0), self.number, 1000 * self.number, 21.0)
        change, self.change = self.change, None
        return [encode_reading(report if change is None else change(report))]

    def decoded(self, data):
        return [decode_reading(data)]

    def special(self, name, wiring, rng):
        def change(report):
            match name:
                case "frozen" | "back":
                    steps = 1 if name == "frozen" else int(rng.integers(2, 1000))
                    return replace(report, sequence=report.sequence - steps, deviation_mm=0.5)
                case "inch":
                    return replace(report, deviation_mm=report.deviation_mm * 1e6 + 2e6)
            return replace(report, status=Status.NOT_REFERENCED, deviation_mm=0.5)

        self.change = change


class _HidPort(UsbPlug):
    """The reports of a HID device: each piece is one, as the system hands it out."""

    async def fresh_report(self, timeout_s):
        return await self.wire.receive(timeout_s)

    async def feature(self, number, length):
        await self.require_there()
        return encode_bar(BarIdentity(100.0, self._bench.serial))

    async def set_feature(self, report):
        await self.require_there()


class Bridge(Gauge):
    """A ballbar bridge that counts its values."""

    plugin = BRIDGE
    free_numbers = True
    specials = {
        "frozen": "frozen", "back": "stale", "unit": "unit", "nan": "nonsense", "micrometres": "unit",
        "queued": "stale",
    }  # fmt: skip
    absent = {"answers_to_others_are_no_reading": "a bridge sends lengths and nothing else"}

    def __init__(self):
        super().__init__()
        self.number = 0

    def driver(self, wiring):
        return BridgedBallbar(wiring.line(greets=self._hello, speaks=lambda: [self._line()]), wiring.clock)

    def _hello(self):
        return [encode_line(Hello("QC20-W", self.serial, 1e-4, 1.1))]

    def _line(self):
        self.number += 1
        return encode_line(BridgeReading(self.true_mm, "good", 21.0, self.number))

    def decoded(self, data):
        return messages(LineReader(), data, decode)

    def special(self, name, wiring, rng):
        delivered = self.number
        stale = encode_line(BridgeReading(0.5, "good", 21.0, delivered - int(rng.integers(0, 50))))
        queued = self._line()
        self.move(rng)
        said = {
            "frozen": encode_line(BridgeReading(0.5, "good", 21.0, delivered)),
            "back": stale,
            "unit": b'{"deviation_mm": 0.0123, "unit": "inch", "sequence": %d}\n' % (self.number + 1),
            "nan": b'{"deviation_mm": %s}\n' % rng.choice([b"NaN", b"Infinity", b"-1e999", b"1e400"]),
            "micrometres": b'{"deviation_mm": 512.3, "sequence": %d}\n' % (self.number + 1),
        }
        if name == "queued":
            wiring.say(queued[: int(rng.integers(1, len(queued) + 1))])
        else:
            wiring.spoil = lambda _: [said[name]]
