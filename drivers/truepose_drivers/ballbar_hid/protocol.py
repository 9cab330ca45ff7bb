"""Our open HID ballbar: input report 1 and feature reports 2 and 3, little endian. See README.md."""

import math
import struct
from dataclasses import dataclass
from enum import IntFlag
from typing import Any

from truepose_drivers.ballbar_hid.report_descriptor import BAR_ID, INPUT_ID, RATE_ID
from truepose_drivers.errors import RemoteProtocolError

COUNTS_PER_MM = 10_000  # the unit of the descriptor: 1e-5 cm, that is 0.1 um
COUNTS_PER_DEGREE = 100
_NO_VALUE = -(2**31)  # outside the field's logical range: HID's null state
_FURTHEST = 2**31 - 1
_COLDEST, _HOTTEST = -27_315, 32_767

_READING = struct.Struct("<BiBBIIh")
_BAR = struct.Struct("<Bi12s")
_RATE = struct.Struct("<BHB")
READING_BYTES, BAR_BYTES, RATE_BYTES = _READING.size, _BAR.size, _RATE.size


class HidBallbarError(RemoteProtocolError):
    """The device sent a report that is none of a ballbar."""


class Status(IntFlag):
    """What else a ballbar has to say."""

    LOW_BATTERY = 1
    OVERSPEED = 2  # moved faster than it can count: its value is lost until it is referenced again
    NOT_REFERENCED = 4  # has no zero of its own since it was switched on, or since it was too fast


_KNOWN_STATUS = sum(Status)


@dataclass(frozen=True, slots=True)
class BarReading:
    """Input report 1."""

    deviation_mm: float  # NaN where the device has none
    out_of_range: bool
    status: Status
    sequence: int
    time_us: int  # the device's own time, which begins again after 71 minutes
    temperature_c: float


@dataclass(frozen=True, slots=True)
class BarIdentity:
    """Feature report 2."""

    nominal_mm: float
    serial: str


@dataclass(frozen=True, slots=True)
class Rate:
    """Feature report 3: how often reports come, and whether they do."""

    rate_hz: int
    running: bool


def encode_reading(reading: BarReading) -> bytes:
    """Return input report 1; what does not fit into a field is limited to it."""
    return _READING.pack(
        INPUT_ID,
        _counts(reading.deviation_mm),
        reading.out_of_range,
        reading.status,
        reading.sequence % 2**32,
        reading.time_us % 2**32,
        max(_COLDEST, min(_HOTTEST, round(reading.temperature_c * COUNTS_PER_DEGREE))),
    )


def decode_reading(report: bytes) -> BarReading:
    """Read input report 1; raises HidBallbarError."""
    _, counts, out, status, sequence, time_us, temperature = _unpack(_READING, INPUT_ID, report)
    if out > 1 or status & ~_KNOWN_STATUS:
        raise HidBallbarError(
            f"report {report[: _READING.size].hex()} has bits that no ballbar sets: check its cable"
        )
    deviation_mm = math.nan if counts == _NO_VALUE else counts / COUNTS_PER_MM
    return BarReading(
        deviation_mm, bool(out), Status(status), sequence, time_us, temperature / COUNTS_PER_DEGREE
    )


def follows(sequence: int, before: int) -> bool:
    """Whether a report's number comes after another's; numbers begin again after 2^32."""
    return 0 < (sequence - before) % 2**32 < 2**31


def encode_bar(bar: BarIdentity) -> bytes:
    """Return feature report 2."""
    return _BAR.pack(BAR_ID, _counts(bar.nominal_mm), bar.serial.encode("ascii", "replace"))


def decode_bar(report: bytes) -> BarIdentity:
    """Read feature report 2; raises HidBallbarError."""
    _, counts, serial = _unpack(_BAR, BAR_ID, report)
    if counts <= 0:
        raise HidBallbarError(
            f"report {report[: _BAR.size].hex()} states a bar of {counts / COUNTS_PER_MM:g} mm:"
            " its nominal length belongs there"
        )
    return BarIdentity(counts / COUNTS_PER_MM, serial.rstrip(b"\0 ").decode("ascii", "replace"))


def encode_rate(rate: Rate) -> bytes:
    """Return feature report 3."""
    return _RATE.pack(RATE_ID, rate.rate_hz, rate.running)


def decode_rate(report: bytes) -> Rate:
    """Read feature report 3; raises HidBallbarError."""
    _, rate_hz, running = _unpack(_RATE, RATE_ID, report)
    return Rate(rate_hz, bool(running))


def _counts(length_mm: float) -> int:
    if math.isnan(length_mm):
        return _NO_VALUE
    return max(-_FURTHEST, min(_FURTHEST, round(max(-1e6, min(1e6, length_mm)) * COUNTS_PER_MM)))


def _unpack(layout: struct.Struct, number: int, report: bytes) -> tuple[Any, ...]:
    # Some systems hand a report out at the length of the longest one, filled up with zeros.
    if len(report) < layout.size or report[0] != number or any(report[layout.size :]):
        raise HidBallbarError(
            f"report {report[:20].hex()} is not report {number} of a ballbar: check that the device is one"
        )
    return layout.unpack_from(report)
