"""A HID ballbar that exists for one process: what umockdev needs to show it to the real hidapi.

umockdev puts its own file system and ioctls under a process, so hidapi's own C code enumerates, opens and
reads a device node. What the device sends is a script of times and bytes.
"""

import struct
from pathlib import Path

from truepose_drivers.ballbar_hid.protocol import (
    BarIdentity,
    BarReading,
    Rate,
    Status,
    encode_bar,
    encode_rate,
    encode_reading,
    report_descriptor,
)

_USB = "/devices/pci0000:00/0000:00:14.0/usb1/1-1"
_INTERFACE = f"{_USB}/1-1:1.0"
_HID = f"{_INTERFACE}/0003:1209:0001.0001"
_LONGEST_DESCRIPTOR = 4096
_NODE = "/dev/hidraw0"


def write_device(folder: Path, serial: str, deviations_mm: list[float], *, every_ms: int) -> list[str]:
    """Write the files and return the command line that runs a program with the device in place."""
    (folder / "device").write_text(_device(serial))
    (folder / "ioctl").write_text(_ioctls(serial))
    (folder / "script").write_bytes(_script(deviations_mm, every_ms))
    return [
        "umockdev-run",
        f"--device={folder / 'device'}",
        f"--ioctl={_NODE}={folder / 'ioctl'}",
        f"--script={_NODE}={folder / 'script'}",
        "--",
    ]


def _device(serial: str) -> str:
    blocks = [
        [
            f"P: {_USB}",
            "N: bus/usb/001/005",
            "E: DEVNAME=/dev/bus/usb/001/005",
            "E: DEVTYPE=usb_device",
            "E: SUBSYSTEM=usb",
            *(f"A: {name}={value}" for name, value in _USB_ATTRIBUTES.items()),
            f"A: serial={serial}",
        ],
        [f"P: {_INTERFACE}", "E: DEVTYPE=usb_interface", "E: SUBSYSTEM=usb", "A: bInterfaceNumber=00"],
        [
            f"P: {_HID}",
            "E: SUBSYSTEM=hid",
            "E: HID_ID=0003:00001209:00000001",
            "E: HID_NAME=Workshop Bar",
            f"E: HID_UNIQ={serial}",
            f"H: report_descriptor={report_descriptor().hex().upper()}",
        ],
        [
            f"P: {_HID}/hidraw/hidraw0",
            "N: hidraw0",
            f"E: DEVNAME={_NODE}",
            "E: SUBSYSTEM=hidraw",
            "E: MAJOR=240",
            "E: MINOR=0",
            "A: dev=240:0",
        ],
    ]
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


_USB_ATTRIBUTES = {
    "idVendor": "1209",
    "idProduct": "0001",
    "bcdDevice": "0100",
    "manufacturer": "Workshop",
    "product": "Bar",
    "busnum": "1",
    "devnum": "5",
}


def _ioctls(serial: str) -> str:
    descriptor = report_descriptor()
    size, bar = struct.pack("<i", len(descriptor)), encode_bar(BarIdentity(100.0, serial))
    rates = [encode_rate(Rate(200, running=running)) for running in (True, False)]
    return "\n".join((
        f"@DEV {_NODE}",
        f"HIDIOCGRDESCSIZE 0 {size.hex().upper()}",
        f"HIDIOCGRDESC 0 {(size + descriptor.ljust(_LONGEST_DESCRIPTOR, bytes(1))).hex().upper()}",
        f"HIDIOCGFEATURE {len(bar)} {bar.hex().upper()}",
        *(f"HIDIOCSFEATURE {len(rate)} {rate.hex().upper()}" for rate in rates),
        "",
    ))


def _script(deviations_mm: list[float], every_ms: int) -> bytes:
    reports = (
        encode_reading(BarReading(deviation_mm, False, Status(0), number, 1000 * number, 21.5))
        for number, deviation_mm in enumerate(deviations_mm, start=1)
    )
    lines = (b"r %d %s" % (every_ms, _escaped(report)) for report in reports)
    return b"\n".join([b"d 0 " + _NODE.encode(), *lines, b""])


def _escaped(data: bytes) -> bytes:
    """Write control characters as ^A and so on, and the caret itself as ^`."""
    return b"".join(
        bytes([ord("^"), byte + 64]) if byte < 32 else b"^`" if byte == ord("^") else bytes([byte])
        for byte in data
    )
