"""Models of ballbars that know their true deviation, and drivers on hostile wires to them."""

import math
from dataclasses import replace

from tests.studies.wires.hostile_link import HostileLink, HostileUsb, Silence
from truepose.sequencing.ballbar.measuring.live import live_state
from truepose_drivers.ballbar_bridge.driver import BridgedBallbar
from truepose_drivers.ballbar_bridge.protocol import BridgeReading, Hello
from truepose_drivers.ballbar_bridge.protocol import encode as encode_line
from truepose_drivers.ballbar_hid.driver import HidBallbar
from truepose_drivers.ballbar_hid.protocol import BarIdentity, BarReading, Status, encode_bar, encode_reading
from truepose_drivers.heidenhain_nd.driver import HeidenhainCounter
from truepose_drivers.heidenhain_nd.protocol import (
    COUNTS_PER_INCH,
    COUNTS_PER_MM,
    MM_PER_INCH,
    Lamps,
    Refused,
    RequestReader,
    encode_reply,
    identity_lines,
    lamps_line,
    printed_line,
    value_line,
)
from truepose_drivers.line_gauges.value_form import Value
from truepose_drivers.mitutoyo_usb_itn.driver import UsbItnGauge
from truepose_drivers.mitutoyo_usb_itn.protocol import DeviceInfo, encode
from truepose_drivers.monotonic_clock import MonotonicClock

_TOLERANCE_MM = 2e-4  # a step of an inch display
_RANGE_MM = 1.0
_PATIENCE_S = 1.0  # virtual


class Gauge:
    """What every ballbar bench has: a true deviation, and how to ask for it."""

    kind = "ballbar"
    specials = ()
    free_numbers = False  # of any number of digits

    def __init__(self):
        self.true_mm = 0.0

    def move(self, rng):
        """The bar is somewhere else before each question; sometimes where whole numbers are."""
        steps = int(rng.integers(-9_999, 10_000)) if rng.integers(4) else 1000 * int(rng.integers(-9, 10))
        self.true_mm = steps / COUNTS_PER_MM

    async def ask(self, device):
        """Return what the service would take for a length, None for none."""
        reading = await device.read()
        usable = live_state(reading, None, _RANGE_MM, unsteady=False) == "in_range"
        return reading.deviation_mm if usable else None

    def is_right(self, deviation_mm):
        return math.isfinite(deviation_mm) and abs(deviation_mm - self.true_mm) <= _TOLERANCE_MM


class Counter(Gauge):
    """A Heidenhain ND, behind a terminal server that remembers."""

    def __init__(self):
        super().__init__()
        self.inch = False
        self.unit_changes = 0  # commands from now until somebody presses the key for the unit
        self.link = HostileLink(self.answer, remembers=True)
        self.driver = HeidenhainCounter(self.link, MonotonicClock(), reply_timeout_s=_PATIENCE_S)
        self.specials = ("unit", "print", "nothing_but_prints")

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
            "A0301": (Refused(),),
            "A0200": (value_line(round(counts)),),
            "A0800": (lamps_line(Lamps(inch=self.inch, inside=True)),),
        }[code]

    def special(self, name, rng):
        printed = encode_reply(printed_line(int(rng.integers(-9999, 9999)), Lamps(inside=True)))
        if name == "unit":
            self.unit_changes = int(rng.integers(1, 8))
        elif name == "print":
            before = bool(rng.integers(2))
            self.link.pieces.append(printed)
            self.link.spoil = lambda said: [printed, *said] if before else [*said, printed]
        else:
            self.link.spoil = lambda said: [printed] * 50 + [Silence()]


class Cable(Gauge):
    """A Mitutoyo USB-ITN, whose packets wait until they are fetched."""

    def __init__(self):
        super().__init__()
        self.inch = False
        self.link = HostileLink(self.answer, remembers=True)
        self.driver = UsbItnGauge(HostileUsb(self.link), MonotonicClock(), reply_timeout_s=_PATIENCE_S)
        self.specials = ("unit", "button", "half_button")

    def answer(self, data):
        return [encode(DeviceInfo("V2") if data == b"V\r" else self._value())]

    def _value(self):
        if self.inch:
            return Value(self.true_mm / MM_PER_INCH, 5)
        return Value(self.true_mm, 4)

    def move(self, rng):
        super().move(rng)
        self.inch = False

    def special(self, name, rng):
        pressed = encode(self._value())  # what it shows when the button is pressed, before it moves on
        self.move(rng)
        if name == "unit":
            self.inch = True
        elif name == "button":
            self.link.pieces.append(pressed)
        else:
            place = int(rng.integers(1, len(pressed)))
            self.link.pieces.append(pressed[:place])
            self.link.spoil = lambda said: [pressed[place:], *said]


class Bar(Gauge):
    """A HID ballbar."""

    def __init__(self):
        super().__init__()
        self.number = 0
        self.link = HostileLink(None, by_itself=self._reports)
        self.driver = HidBallbar(_HidPort(self), MonotonicClock(), report_timeout_s=_PATIENCE_S)
        self.specials = ("frozen", "back", "inch", "lost_zero")
        self.change = None

    def _reports(self):
        self.number += 1
        report = BarReading(self.true_mm, False, Status(0), self.number, 1000 * self.number, 21.0)
        change, self.change = self.change, None
        return [encode_reading(report if change is None else change(report))]

    def special(self, name, rng):
        def change(report):
            match name:
                case "frozen" | "back":
                    steps = 1 if name == "frozen" else int(rng.integers(2, 1000))
                    return replace(report, sequence=report.sequence - steps, deviation_mm=0.5)
                case "inch":
                    return replace(report, deviation_mm=report.deviation_mm * 1e6 + 1e6)
            return replace(report, status=Status.NOT_REFERENCED, deviation_mm=0.5)

        self.change = change


class _HidPort(HostileUsb):
    """The reports of a HID device: each piece is one, as the system hands it out."""

    def __init__(self, bar):
        super().__init__(bar.link)
        self._bar = encode_bar(BarIdentity(100.0, "BAR-7"))

    async def fresh_report(self, timeout_s):
        return await self.link.receive(timeout_s)

    async def feature(self, number, length):
        return self._bar

    async def set_feature(self, report):
        pass


class Bridge(Gauge):
    """A ballbar bridge that counts its values."""

    free_numbers = True

    def __init__(self):
        super().__init__()
        self.number = 0
        self.link = HostileLink(None, by_itself=self._lines)
        self.driver = BridgedBallbar(self.link, MonotonicClock(), value_timeout_s=_PATIENCE_S)
        self.specials = ("frozen", "back", "unit", "nan", "micrometres", "queued")

    def _line(self):
        self.number += 1
        return encode_line(BridgeReading(self.true_mm, "good", 21.0, self.number))

    def _lines(self):
        if self.number == 0:
            return [encode_line(Hello("QC20-W", "12A345", 1e-4, 1.1)), self._line()]
        return [self._line()]

    def special(self, name, rng):
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
            self.link.pieces.append(queued[: int(rng.integers(1, len(queued) + 1))])
        else:
            self.link.spoil = lambda _: [said[name]]
