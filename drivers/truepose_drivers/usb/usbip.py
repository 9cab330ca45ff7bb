"""Messages of USB/IP: transfers of a USB device over TCP, big endian.

Source: Documentation/usb/usbip_protocol in the Linux kernel, protocol version 0x0111. A connection begins
with one operation (list of devices, or import of one of them); after an import it carries transfers, each of
which is answered when it has completed, in any order.
"""

import struct
from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.errors import RemoteProtocolError

PORT = 3240
VERSION = 0x0111

_OPERATION = struct.Struct(">HHI")
_COUNT = struct.Struct(">I")
_RECORD = struct.Struct(">256s32sIIIHHHBBBBBB")
_INTERFACE = struct.Struct(">BBBx")
_BUSID = struct.Struct(">32s")
_BASIC = struct.Struct(">IIIII")
_SUBMIT = struct.Struct(">Iiiii8s")
_UNLINK = struct.Struct(">I24x")
_RETURN = struct.Struct(">iiiii8x")
_RETURN_UNLINK = struct.Struct(">i24x")

OPERATION_BYTES, COUNT_BYTES, RECORD_BYTES = _OPERATION.size, _COUNT.size, _RECORD.size
INTERFACE_BYTES, BUSID_BYTES = _INTERFACE.size, _BUSID.size
HEADER_BYTES = _BASIC.size + _SUBMIT.size  # of every message about a transfer

LIST_REQUEST, LIST_REPLY = 0x8005, 0x0005
IMPORT_REQUEST, IMPORT_REPLY = 0x8003, 0x0003
OK, UNAVAILABLE, BUSY, IN_ERROR, NO_DEVICE = range(5)  # status of an operation

_SUBMIT_COMMAND, _UNLINK_COMMAND, _SUBMIT_REPLY, _UNLINK_REPLY = 1, 2, 3, 4
_OUT, _IN = 0, 1
NOT_ISOCHRONOUS = 0
_LONGEST_TRANSFER = 1 << 20  # control and interrupt transfers are far shorter

# Status of a transfer: errors of Linux, negative
STALLED = -32  # EPIPE
UNLINKED = -104  # ECONNRESET
GONE = -19  # ENODEV


class UsbipProtocolError(RemoteProtocolError):
    """The other end does not speak USB/IP."""


@dataclass(frozen=True, slots=True)
class Operation:
    """Head of a request or reply before any transfer."""

    code: int
    status: int = OK


@dataclass(frozen=True, slots=True)
class DeviceRecord:
    """A device as a server lists it."""

    path: str
    busid: str
    bus: int
    number: int
    speed: int  # 1 low, 2 full, 3 high
    vendor: int
    product: int
    release: int
    device_class: int
    device_subclass: int
    device_protocol: int
    configuration: int
    configurations: int
    interfaces: int

    @property
    def id(self) -> int:
        """What transfers name it by."""
        return self.bus << 16 | self.number


@dataclass(frozen=True, slots=True)
class Submit:
    """Request: a transfer. `length` is what is sent, or what may come at most."""

    sequence: int
    device: int
    endpoint: int
    is_in: bool
    length: int
    setup: bytes = bytes(8)
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class Unlink:
    """Request: give up the transfer `victim`."""

    sequence: int
    device: int
    victim: int


@dataclass(frozen=True, slots=True)
class SubmitReply:
    """Reply: a transfer has completed. For one to the device `length` says how much it took."""

    sequence: int
    status: int
    length: int
    data: bytes = b""


@dataclass(frozen=True, slots=True)
class UnlinkReply:
    """Reply: the transfer was given up (UNLINKED), or had completed before (0)."""

    sequence: int
    status: int


Request: TypeAlias = Submit | Unlink
Reply: TypeAlias = SubmitReply | UnlinkReply


def encode_operation(operation: Operation) -> bytes:
    """Return the head of an operation."""
    return _OPERATION.pack(VERSION, operation.code, operation.status)


def decode_operation(data: bytes) -> Operation:
    """Read the head of an operation; raises UsbipProtocolError for another protocol or version."""
    version, code, status = _OPERATION.unpack(data)
    if version != VERSION:
        raise UsbipProtocolError(f"version 0x{version:04x} is not USB/IP 0x{VERSION:04x}")
    return Operation(code, status)


def encode_count(count: int) -> bytes:
    """Return the number of devices of a list."""
    return _COUNT.pack(count)


def decode_count(data: bytes) -> int:
    """Read the number of devices of a list."""
    count: int = _COUNT.unpack(data)[0]
    return count


def encode_busid(busid: str) -> bytes:
    """Return the name of a device, padded."""
    return _BUSID.pack(busid.encode("ascii", "replace"))


def decode_busid(data: bytes) -> str:
    """Read the name of a device."""
    return _text(data)


def encode_record(record: DeviceRecord) -> bytes:
    """Return a device record."""
    return _RECORD.pack(
        record.path.encode("ascii", "replace"),
        record.busid.encode("ascii", "replace"),
        record.bus,
        record.number,
        record.speed,
        record.vendor,
        record.product,
        record.release,
        record.device_class,
        record.device_subclass,
        record.device_protocol,
        record.configuration,
        record.configurations,
        record.interfaces,
    )


def decode_record(data: bytes) -> DeviceRecord:
    """Read a device record."""
    path, busid, *numbers = _RECORD.unpack(data)
    return DeviceRecord(_text(path), _text(busid), *numbers)


def encode_interface(interface_class: int, subclass: int, protocol: int) -> bytes:
    """Return what a list says of an interface."""
    return _INTERFACE.pack(interface_class, subclass, protocol)


def encode_request(request: Request) -> bytes:
    """Return the bytes of a request about a transfer, data included."""
    match request:
        case Submit(sequence, device, endpoint, is_in, length, setup, data):
            head = _BASIC.pack(_SUBMIT_COMMAND, sequence, device, _IN if is_in else _OUT, endpoint)
            return head + _SUBMIT.pack(0, length, 0, NOT_ISOCHRONOUS, 0, setup) + data
        case Unlink(sequence, device, victim):
            return _BASIC.pack(_UNLINK_COMMAND, sequence, device, _OUT, 0) + _UNLINK.pack(victim)


def decode_request(header: bytes) -> tuple[Request, int]:
    """Read the header of a request; returns it and how many bytes of data follow it.

    Raises UsbipProtocolError.
    """
    command, sequence, device, direction, endpoint = _BASIC.unpack_from(header)
    rest = header[_BASIC.size :]
    if command == _UNLINK_COMMAND:
        return Unlink(sequence, device, _UNLINK.unpack(rest)[0]), 0
    if command != _SUBMIT_COMMAND:
        raise UsbipProtocolError(f"command {command} is not a USB/IP request")
    _, length, _, _, _, setup = _SUBMIT.unpack(rest)
    is_in = direction == _IN
    submit = Submit(sequence, device, endpoint, is_in, _checked_length(length), setup)
    return submit, 0 if is_in else length


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply about a transfer, data included."""
    match reply:
        case SubmitReply(sequence, status, length, data):
            head = _BASIC.pack(_SUBMIT_REPLY, sequence, 0, 0, 0)
            return head + _RETURN.pack(status, length, 0, NOT_ISOCHRONOUS, 0) + data
        case UnlinkReply(sequence, status):
            return _BASIC.pack(_UNLINK_REPLY, sequence, 0, 0, 0) + _RETURN_UNLINK.pack(status)


def decode_reply(header: bytes) -> Reply:
    """Read the header of a reply; data of a transfer from the device follow it, `length` bytes.

    Raises UsbipProtocolError.
    """
    command, sequence, _, _, _ = _BASIC.unpack_from(header)
    rest = header[_BASIC.size :]
    if command == _UNLINK_REPLY:
        return UnlinkReply(sequence, _RETURN_UNLINK.unpack(rest)[0])
    if command != _SUBMIT_REPLY:
        raise UsbipProtocolError(f"command {command} is not a USB/IP reply")
    status, length, _, _, _ = _RETURN.unpack(rest)
    return SubmitReply(sequence, status, _checked_length(length))


def _checked_length(length: int) -> int:
    if not 0 <= length <= _LONGEST_TRANSFER:
        raise UsbipProtocolError(f"a transfer of {length} bytes does not come from a measuring device")
    return length


def _text(data: bytes) -> str:
    return data.split(b"\0", 1)[0].decode("ascii", "replace")
