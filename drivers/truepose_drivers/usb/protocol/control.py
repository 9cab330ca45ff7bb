"""Requests on endpoint 0. Source: USB 2.0, section 9.3 and 9.4; HID 1.11, section 7.2."""

import struct
from dataclasses import dataclass
from enum import IntEnum

from truepose_drivers.errors import RemoteProtocolError

_SETUP = struct.Struct("<BBHHH")
SETUP_BYTES = _SETUP.size

# bmRequestType: direction, type, recipient
TO_DEVICE, TO_INTERFACE, TO_ENDPOINT = 0x00, 0x01, 0x02
FROM_DEVICE, FROM_INTERFACE, FROM_ENDPOINT = 0x80, 0x81, 0x82
CLASS_TO_INTERFACE, CLASS_FROM_INTERFACE = 0x21, 0xA1
CLASS_TO_PORT = 0x23
VENDOR_TO_DEVICE, VENDOR_FROM_DEVICE = 0x40, 0xC0

PORT_RESET = 4  # feature of a hub's port, USB 2.0 table 11-17


class StandardRequest(IntEnum):
    """USB 2.0 table 9-4."""

    GET_STATUS = 0
    CLEAR_FEATURE = 1
    SET_FEATURE = 3
    SET_ADDRESS = 5
    GET_DESCRIPTOR = 6
    GET_CONFIGURATION = 8
    SET_CONFIGURATION = 9
    GET_INTERFACE = 10
    SET_INTERFACE = 11


class HidRequest(IntEnum):
    """HID 1.11, section 7.2."""

    GET_REPORT = 1
    GET_IDLE = 2
    GET_PROTOCOL = 3
    SET_REPORT = 9
    SET_IDLE = 10
    SET_PROTOCOL = 11


class ReportType(IntEnum):
    """High byte of wValue in GET_REPORT and SET_REPORT."""

    INPUT = 1
    OUTPUT = 2
    FEATURE = 3


@dataclass(frozen=True, slots=True)
class Setup:
    """The setup packet of a control transfer."""

    request_type: int
    request: int
    value: int = 0
    index: int = 0
    length: int = 0

    @property
    def is_in(self) -> bool:
        """Whether data come from the device."""
        return bool(self.request_type & 0x80)


def encode_setup(setup: Setup) -> bytes:
    """Return the eight bytes of a setup packet."""
    return _SETUP.pack(setup.request_type, setup.request, setup.value, setup.index, setup.length)


def decode_setup(data: bytes) -> Setup:
    """Read a setup packet; raises RemoteProtocolError."""
    if len(data) != SETUP_BYTES:
        raise RemoteProtocolError(f"a setup packet has {SETUP_BYTES} bytes, not {len(data)}")
    return Setup(*_SETUP.unpack(data))
