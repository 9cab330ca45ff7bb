"""What a Mitutoyo USB-ITN input tool says once it has been taken out of keyboard mode.

Source: public clients pytuyo and mitutoyo_reader; form of the data line as in Mitutoyo's manual 99MAF600B.
Commands go out in a vendor request; replies come in packets of the interrupt endpoint and end with CR:
``01A+0000.1234``, ``1...`` about the cable itself, ``91n`` errors.
"""

from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader
from truepose_drivers.line_gauges.protocol import Value, data_line, read_data_line, read_error_line

VENDOR, PRODUCT = 0x0FE7, 0x4001
PACKET_BYTES = 8

# Vendor requests on endpoint 0
SET_MODE, GET_MODE, SEND_COMMAND = 1, 2, 3
SERIAL_MODE = 0xA5A5  # value of SET_MODE: text instead of key strokes

READ_VALUE = b"1\r"
READ_DEVICE = b"V\r"

_END = b"\r"
_LONGEST_REPLY = 64
_CHANNEL = 1  # the only one of a cable
_FIELD_WIDTH = 9  # the manual gives the value 8 characters, public clients saw 9


class ItnProtocolError(RemoteProtocolError):
    """The cable sent something that is no reply."""


@dataclass(frozen=True, slots=True)
class DeviceInfo:
    """What the cable says of itself."""

    text: str


@dataclass(frozen=True, slots=True)
class Error:
    """The cable has no value: 911, 912, ..."""

    number: int


Reply: TypeAlias = Value | DeviceInfo | Error


def encode(reply: Reply) -> bytes:
    """Return the characters of a reply."""
    match reply:
        case Value():
            text = data_line(_CHANNEL, reply, _FIELD_WIDTH)
        case DeviceInfo(text):
            text = f"1{text}"
        case Error(number):
            text = f"{number}"
    return text.encode("ascii", "replace") + _END


def decode(data: bytes) -> Reply:
    """Read a reply without its end; raises ItnProtocolError."""
    text = data.decode("ascii", "replace")
    if (read := read_data_line(text)) is not None and read[0] == _CHANNEL:
        return read[1]
    if (number := read_error_line(text)) is not None:
        return Error(number)
    if text.startswith("1"):
        return DeviceInfo(text[1:].strip())
    raise ItnProtocolError(f"{text!r} is not a reply from a USB-ITN cable")


class ReplyReader(StreamReader):
    """Puts packets together until a reply ends."""

    def receive_data(self, data: bytes) -> None:
        """Append a packet; zeros at its end only fill it up."""
        super().receive_data(data.rstrip(b"\0"))

    def next_message(self) -> Reply | None:
        """Take the oldest whole reply, None until more packets arrive; raises ItnProtocolError."""
        end = self._buffer.find(_END)
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_REPLY:
            raise ItnProtocolError(
                f"{bytes(self._buffer[:20])!r}... does not end: the device is not a USB-ITN cable"
            )
        if end < 0:
            return None
        return decode(self._take(end, drop=len(_END)))
