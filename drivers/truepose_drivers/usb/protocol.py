"""Bytes of USB: requests on endpoint 0, and what a device says of itself; no I/O.

Source: USB 2.0, sections 9.3, 9.4 and 9.6; HID 1.11, sections 6.2.1 and 7.2.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
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


_DEVICE = struct.Struct("<BBHBBBBHHHBBBB")
_CONFIGURATION = struct.Struct("<BBHBBBBB")
_INTERFACE = struct.Struct("<BBBBBBBBB")
_HID = struct.Struct("<BBHBBBH")
_ENDPOINT = struct.Struct("<BBBBHB")
_HEAD_BYTES = 2
_STRING_BYTES = 255

_USB_2_0 = 0x0200
_HID_1_11 = 0x0111
_BUS_POWERED = 0x80
_ENGLISH_US = 0x0409
INTERRUPT = 3  # kind of transfer, low two bits of bmAttributes
HID_CLASS = 3


class DescriptorType(IntEnum):
    """USB 2.0 table 9-5, and those of HID."""

    DEVICE = 1
    CONFIGURATION = 2
    STRING = 3
    INTERFACE = 4
    ENDPOINT = 5
    HID = 0x21
    REPORT = 0x22


class DescriptorError(RemoteProtocolError):
    """A device describes itself in a way that USB does not know."""


@dataclass(frozen=True, slots=True)
class Device:
    """Device descriptor; strings are numbers of string descriptors, 0 where there is none."""

    vendor: int
    product: int
    release: int  # binary coded decimal
    device_class: int = 0  # 0: each interface has its own
    device_subclass: int = 0
    device_protocol: int = 0
    manufacturer_string: int = 1
    product_string: int = 2
    serial_string: int = 3
    configurations: int = 1
    packet_bytes: int = 64  # of endpoint 0
    usb: int = _USB_2_0


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Endpoint descriptor."""

    address: int  # bit 7: towards the computer
    attributes: int
    packet_bytes: int
    interval: int  # milliseconds, at full speed


@dataclass(frozen=True, slots=True)
class Interface:
    """Interface descriptor with what belongs to it."""

    number: int
    interface_class: int
    subclass: int
    protocol: int
    endpoints: tuple[Endpoint, ...]
    alternate: int = 0
    string: int = 0
    report_descriptor_bytes: int | None = None  # of a HID interface


@dataclass(frozen=True, slots=True)
class Configuration:
    """Configuration descriptor with its interfaces."""

    value: int
    interfaces: tuple[Interface, ...]
    attributes: int = _BUS_POWERED
    power: int = 50  # in units of 2 mA
    string: int = 0
    total_bytes: int = field(default=0, compare=False)  # as read


def encode_device(device: Device) -> bytes:
    """Return the 18 bytes of a device descriptor."""
    return _DEVICE.pack(
        _DEVICE.size,
        DescriptorType.DEVICE,
        device.usb,
        device.device_class,
        device.device_subclass,
        device.device_protocol,
        device.packet_bytes,
        device.vendor,
        device.product,
        device.release,
        device.manufacturer_string,
        device.product_string,
        device.serial_string,
        device.configurations,
    )


def decode_device(data: bytes) -> Device:
    """Read a device descriptor; raises DescriptorError."""
    if len(data) < _DEVICE.size or data[1] != DescriptorType.DEVICE:
        raise DescriptorError(f"{data[:20].hex()} is not a device descriptor")
    _, _, usb, class_, subclass, protocol, packet, vendor, product, release, maker, name, serial, count = (
        _DEVICE.unpack_from(data)
    )
    return Device(
        vendor, product, release, class_, subclass, protocol, maker, name, serial, count, packet, usb
    )


def encode_configuration(configuration: Configuration) -> bytes:
    """Return a configuration descriptor with all that follows it."""
    body = b"".join(map(_encode_interface, configuration.interfaces))
    numbers = {interface.number for interface in configuration.interfaces}
    head = _CONFIGURATION.pack(
        _CONFIGURATION.size,
        DescriptorType.CONFIGURATION,
        _CONFIGURATION.size + len(body),
        len(numbers),
        configuration.value,
        configuration.string,
        configuration.attributes,
        configuration.power,
    )
    return head + body


def encode_hid(interface: Interface) -> bytes:
    """Return the HID descriptor of an interface; empty where it is none."""
    if interface.report_descriptor_bytes is None:
        return b""
    return _HID.pack(
        _HID.size,
        DescriptorType.HID,
        _HID_1_11,
        0,  # no country
        1,
        DescriptorType.REPORT,
        interface.report_descriptor_bytes,
    )


def decode_configuration(data: bytes) -> Configuration:
    """Read a configuration with all that follows it; raises DescriptorError."""
    parts = list(_parts(data))
    if not parts or parts[0][1] != DescriptorType.CONFIGURATION or len(parts[0]) < _CONFIGURATION.size:
        raise DescriptorError(f"{data[:20].hex()} is not a configuration descriptor")
    _, _, total, _, value, string, attributes, power = _CONFIGURATION.unpack_from(parts[0])
    starts = [index for index, part in enumerate(parts) if part[1] == DescriptorType.INTERFACE]
    interfaces = tuple(
        _decode_interface(parts[start:end])
        for start, end in zip(starts, [*starts[1:], len(parts)], strict=True)
    )
    return Configuration(value, interfaces, attributes, power, string, total)


def configuration_total_bytes(data: bytes) -> int:
    """Read from the first nine bytes how long the whole is; raises DescriptorError."""
    if len(data) < _CONFIGURATION.size or data[1] != DescriptorType.CONFIGURATION:
        raise DescriptorError(f"{data[:20].hex()} is not a configuration descriptor")
    total: int = _CONFIGURATION.unpack_from(data)[2]
    return total


CONFIGURATION_HEAD_BYTES = _CONFIGURATION.size
DEVICE_BYTES = _DEVICE.size


def encode_string(text: str) -> bytes:
    """Return a string descriptor, UTF-16, cut to what one can hold."""
    # 252 of the 253 bytes that fit: an odd number would end in half a character.
    data = text.encode("utf-16-le")[: _STRING_BYTES - _HEAD_BYTES - 1]
    return bytes([len(data) + _HEAD_BYTES, DescriptorType.STRING]) + data


def encode_languages() -> bytes:
    """Return string descriptor 0: English is all there is."""
    return struct.pack("<BBH", 4, DescriptorType.STRING, _ENGLISH_US)


def _encode_interface(interface: Interface) -> bytes:
    head = _INTERFACE.pack(
        _INTERFACE.size,
        DescriptorType.INTERFACE,
        interface.number,
        interface.alternate,
        len(interface.endpoints),
        interface.interface_class,
        interface.subclass,
        interface.protocol,
        interface.string,
    )
    endpoints = (
        _ENDPOINT.pack(
            _ENDPOINT.size,
            DescriptorType.ENDPOINT,
            endpoint.address,
            endpoint.attributes,
            endpoint.packet_bytes,
            endpoint.interval,
        )
        for endpoint in interface.endpoints
    )
    return head + encode_hid(interface) + b"".join(endpoints)


def _decode_interface(parts: list[bytes]) -> Interface:
    _, _, number, alternate, _, class_, subclass, protocol, string = _unpack(_INTERFACE, parts[0])
    endpoints, report_bytes = [], None
    for part in parts[1:]:
        if part[1] == DescriptorType.ENDPOINT:
            _, _, address, attributes, packet, interval = _unpack(_ENDPOINT, part)
            endpoints.append(Endpoint(address, attributes, packet, interval))
        elif part[1] == DescriptorType.HID:
            report_bytes = _unpack(_HID, part)[-1]
    return Interface(number, class_, subclass, protocol, tuple(endpoints), alternate, string, report_bytes)


def _parts(data: bytes) -> Iterator[bytes]:
    """Cut a chain of descriptors; each says how long it is."""
    while data:
        if not _HEAD_BYTES <= data[0] <= len(data):
            raise DescriptorError(f"a descriptor of {data[0]} bytes where {len(data)} bytes are left")
        yield data[: data[0]]
        data = data[data[0] :]


def _unpack(layout: struct.Struct, part: bytes) -> tuple[int, ...]:
    if len(part) < layout.size:
        raise DescriptorError(f"descriptor {part.hex()} is shorter than {layout.size} bytes")
    return layout.unpack_from(part)
