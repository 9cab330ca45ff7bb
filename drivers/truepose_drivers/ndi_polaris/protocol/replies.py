"""What the camera answers: text with four digits of checksum and CR, or bytes with a head of their own."""

import re
import struct
from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.ndi_polaris.protocol.checksum import crc16, crc_text
from truepose_drivers.stream_reader import StreamReader

_BINARY_START = b"\xc4\xa5"  # 0xA5C4, low byte first
_HEAD = struct.Struct("<2sHH")  # start, length of the body, checksum of both
_CRC = struct.Struct("<H")
_CRC_DIGITS = 4
_LONGEST_TEXT = 16_384
_LONGEST_BODY = 16_384  # a body of 255 tools has 11 kB
_ERROR = re.compile(r"ERROR([0-9A-F]{2})")


class NdiProtocolError(RemoteProtocolError):
    """The camera sent something that its protocol does not know."""


@dataclass(frozen=True, slots=True)
class Text:
    """A reply in characters, without its checksum."""

    text: str


@dataclass(frozen=True, slots=True)
class Binary:
    """A reply in bytes, without head and checksum."""

    body: bytes


Reply: TypeAlias = Text | Binary
OKAY = Text("OKAY")
RESET = Text("RESET")  # the one thing that comes unasked: the camera was started again


def error_text(code: int) -> Text:
    """Return the reply of a camera that refuses."""
    return Text(f"ERROR{code:02X}")


def error_code(reply: Reply) -> int | None:
    """Return the number of a refusal, None for any other reply."""
    found = _ERROR.fullmatch(reply.text) if isinstance(reply, Text) else None
    return None if found is None else int(found[1], 16)


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply."""
    if isinstance(reply, Text):
        text = reply.text.encode("ascii", "replace")
        return text + crc_text(text) + b"\r"
    head = _BINARY_START + _CRC.pack(len(reply.body))
    return head + _CRC.pack(crc16(head)) + reply.body + _CRC.pack(crc16(reply.body))


class ReplyReader(StreamReader):
    """Reassembles replies; the program's side of the wire."""

    def next_message(self) -> Reply | None:
        """Take the oldest whole reply, None until more arrives; raises NdiProtocolError."""
        if self._buffer[:1] == _BINARY_START[:1]:
            return self._next_binary()
        return self._next_text()

    def _next_text(self) -> Text | None:
        end = self._buffer.find(b"\r")
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_TEXT:
            raise NdiProtocolError("the camera's reply does not end: is this the right port?")
        return None if end < 0 else _checked_text(self._take(end, drop=1))

    def _next_binary(self) -> Binary | None:
        if len(self._buffer) < _HEAD.size:
            return None
        start, length, crc = _HEAD.unpack_from(self._buffer)
        if start != _BINARY_START or crc != crc16(self._buffer[:4]) or length > _LONGEST_BODY:
            raise NdiProtocolError("the camera's binary reply is damaged at its head: connect again")
        if len(self._buffer) < _HEAD.size + length + _CRC.size:
            return None
        body = self._take(_HEAD.size + length + _CRC.size)[_HEAD.size :]
        if crc16(body) != 0:
            raise NdiProtocolError(
                "the camera's binary reply is damaged, its checksum is wrong: connect again"
            )
        return Binary(body[:length])


def _checked_text(line: bytes) -> Text:
    text, digits = line[:-_CRC_DIGITS], line[-_CRC_DIGITS:]
    if digits != crc_text(text):
        raise NdiProtocolError(
            f"the camera's reply {line[:40]!r} is damaged, its checksum is wrong: connect again"
        )
    if not text.isascii():
        raise NdiProtocolError(f"the camera's reply {line[:40]!r} is no text: is this the right port?")
    return Text(text.decode("ascii"))
