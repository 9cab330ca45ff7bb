"""Where a USB device is, as a cell file says it."""

import re
from dataclasses import dataclass
from typing import Final, TypeAlias
from urllib.parse import urlsplit

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConfigurationError
from truepose_drivers.usb.protocol import usbip

_LOCAL: Final = re.compile(r"([0-9a-fA-F]{4}):([0-9a-fA-F]{4})(?::(.+))?")
_ONLY_DEVICE: Final = "1-1"  # what a server of a single device calls it
_FORMS: Final = "vendor:product[:serial number], such as 0fe7:4001, or usbip://host[:port]/busid"


@dataclass(frozen=True, slots=True)
class LocalUsb:
    """A device of this computer; without `serial` the first of its kind."""

    vendor: int
    product: int
    serial: str | None = None

    def __str__(self) -> str:
        numbers = f"{self.vendor:04x}:{self.product:04x}"
        return numbers if self.serial is None else f"{numbers}:{self.serial}"


@dataclass(frozen=True, slots=True)
class RemoteUsb:
    """A device behind a USB/IP server."""

    host: str
    port: int
    busid: str

    def __str__(self) -> str:
        return f"usbip://{self.host}:{self.port}/{self.busid}"


UsbAddress: TypeAlias = LocalUsb | RemoteUsb


def usb_address(options: Options, default: str | None = None) -> UsbAddress:
    """Read option `usb`, or `host` and `port` of a USB/IP server that has one device.

    Raises ConfigurationError where both are given, or neither and there is no `default`.
    """
    text = option.text(options, "usb")
    if "host" in options or "port" in options:
        if text is not None:
            raise ConfigurationError("usb and host are two ways to the same device: give one of them")
        return RemoteUsb(option.host(options), option.port(options, usbip.PORT), _ONLY_DEVICE)
    text = text or default
    if text is None:
        raise ConfigurationError(f"option usb is missing: give {_FORMS}")
    return _remote(text) if text.startswith("usbip:") else _local(text)


def _local(text: str) -> LocalUsb:
    match = _LOCAL.fullmatch(text.strip())
    if match is None:
        raise ConfigurationError(f"option usb is {text!r}: give {_FORMS}")
    vendor, product, serial = match.groups()
    return LocalUsb(int(vendor, 16), int(product, 16), serial)


def _remote(text: str) -> RemoteUsb:
    try:
        parts = urlsplit(text)
        host, port, busid = parts.hostname, parts.port or usbip.PORT, parts.path.strip("/")
    except ValueError as error:
        raise ConfigurationError(f"option usb is {text!r} ({error}): give {_FORMS}") from error
    if not host or not busid or len(busid) >= usbip.BUSID_BYTES:
        raise ConfigurationError(f"option usb is {text!r}: give {_FORMS}")
    return RemoteUsb(host, port, busid)
