"""Our open HID ballbar: its reports, little endian, and their descriptor. See README.md.

Source: Device Class Definition for HID 1.11, section 6.2.2; HID usage tables, pages 0x20 (sensors) and
0xFF00 to 0xFFFF (vendor defined).
"""

import math
import struct
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from itertools import chain
from typing import Any

from truepose_drivers.errors import RemoteProtocolError

INPUT_ID, BAR_ID, RATE_ID = 1, 2, 3  # report numbers: reading; the bar; rate and start

SENSOR_PAGE, BALLBAR_PAGE = 0x20, 0xFF42
DISTANCE_1D = 0x87  # the collection
DISTANCE, OUT_OF_RANGE = 0x479, 0x47D  # data fields of the sensor page


class BallbarUsage(IntEnum):
    """Usages on our own page."""

    STATUS = 0x01
    SEQUENCE = 0x02
    TIME_US = 0x03
    TEMPERATURE = 0x04
    NOMINAL_LENGTH = 0x05
    SERIAL_NUMBER = 0x06
    RATE_HZ = 0x07
    RUNNING = 0x08


_CENTIMETRE = 0x11  # SI linear, length to the first power
_KELVIN = 0x10001  # SI linear, temperature to the first power
_TENTH_OF_A_MICRON = -5  # 1e-5 cm
_CENTIKELVIN = -2
_VARIABLE, _NULL_STATE = 0x02, 0x40  # a value outside the logical range means that there is none


class _Main(IntEnum):
    INPUT = 0x80
    FEATURE = 0xB0
    COLLECTION = 0xA0
    END = 0xC0


class _Global(IntEnum):
    USAGE_PAGE = 0x04
    LOGICAL_MINIMUM = 0x14
    LOGICAL_MAXIMUM = 0x24
    UNIT_EXPONENT = 0x54
    UNIT = 0x64
    REPORT_SIZE = 0x74
    REPORT_ID = 0x84
    REPORT_COUNT = 0x94


_USAGE = 0x08
_APPLICATION = 0x01


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a report."""

    page: int
    usage: int
    bits: int
    minimum: int
    maximum: int
    unit: int = 0
    exponent: int = 0
    count: int = 1
    may_be_absent: bool = False


_INT32 = (32, -(2**31) + 1, 2**31 - 1)  # -2**31 is left out: it means that there is no value
_UINT8 = (8, 0, 255)
_UINT16 = (16, 0, 65_535)
# HID has no unsigned 32-bit range that every parser reads alike; as signed they count round just so.
_COUNTER32 = (32, -(2**31), 2**31 - 1)

REPORTS: tuple[tuple[_Main, int, tuple[Field, ...]], ...] = (
    (
        _Main.INPUT,
        INPUT_ID,
        (
            Field(SENSOR_PAGE, DISTANCE, *_INT32, _CENTIMETRE, _TENTH_OF_A_MICRON, may_be_absent=True),
            Field(SENSOR_PAGE, OUT_OF_RANGE, 8, 0, 1),
            Field(BALLBAR_PAGE, BallbarUsage.STATUS, *_UINT8),
            Field(BALLBAR_PAGE, BallbarUsage.SEQUENCE, *_COUNTER32),
            Field(BALLBAR_PAGE, BallbarUsage.TIME_US, *_COUNTER32),
            Field(BALLBAR_PAGE, BallbarUsage.TEMPERATURE, 16, -27_315, 32_767, _KELVIN, _CENTIKELVIN),
        ),
    ),
    (
        _Main.FEATURE,
        BAR_ID,
        (
            Field(BALLBAR_PAGE, BallbarUsage.NOMINAL_LENGTH, *_INT32, _CENTIMETRE, _TENTH_OF_A_MICRON),
            Field(BALLBAR_PAGE, BallbarUsage.SERIAL_NUMBER, *_UINT8, count=12),
        ),
    ),
    (
        _Main.FEATURE,
        RATE_ID,
        (
            Field(BALLBAR_PAGE, BallbarUsage.RATE_HZ, *_UINT16),
            Field(BALLBAR_PAGE, BallbarUsage.RUNNING, 8, 0, 1),
        ),
    ),
)


def report_descriptor() -> bytes:
    """Compose the report descriptor, item by item."""
    reports = chain.from_iterable(_report(kind, number, fields) for kind, number, fields in REPORTS)
    return b"".join((
        _unsigned(_Global.USAGE_PAGE, SENSOR_PAGE),
        _unsigned(_USAGE, DISTANCE_1D),
        _unsigned(_Main.COLLECTION, _APPLICATION),
        *reports,
        bytes([_Main.END]),
    ))


def report_bytes(number: int) -> int:
    """Length of a report by its number, which leads it."""
    fields = next(fields for _, found, fields in REPORTS if found == number)
    return 1 + sum(field.bits * field.count for field in fields) // 8


def _report(kind: _Main, number: int, fields: tuple[Field, ...]) -> list[bytes]:
    items = [_unsigned(_Global.REPORT_ID, number)]
    for field in fields:
        flags = _VARIABLE | (_NULL_STATE if field.may_be_absent else 0)
        items += [
            _unsigned(_Global.USAGE_PAGE, field.page),
            _unsigned(_USAGE, field.usage),
            # Hosts read the data of these two items as signed: a maximum of 255 takes two bytes, not one.
            _signed(_Global.LOGICAL_MINIMUM, field.minimum),
            _signed(_Global.LOGICAL_MAXIMUM, field.maximum),
            _unsigned(_Global.UNIT, field.unit),
            _unsigned(_Global.UNIT_EXPONENT, field.exponent & 0x0F),  # a nibble, two's complement
            _unsigned(_Global.REPORT_SIZE, field.bits),
            _unsigned(_Global.REPORT_COUNT, field.count),
            _unsigned(kind, flags),
        ]
    return items


def _unsigned(tag: int, value: int) -> bytes:
    length = 1 if value < 2**8 else 2 if value < 2**16 else 4
    return _item(tag, value.to_bytes(length, "little"))


def _signed(tag: int, value: int) -> bytes:
    length = next(length for length in (1, 2, 4) if -(2 ** (8 * length - 1)) <= value < 2 ** (8 * length - 1))
    return _item(tag, value.to_bytes(length, "little", signed=True))


def _item(tag: int, data: bytes) -> bytes:
    """Return a short item; two bits of its head say how many bytes follow, 3 meaning four."""
    return bytes([tag | {1: 1, 2: 2, 4: 3}[len(data)]]) + data


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
            f"report {report[: _READING.size].hex()} has bits set that no ballbar uses: check its cable"
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
            " expected its nominal length"
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
