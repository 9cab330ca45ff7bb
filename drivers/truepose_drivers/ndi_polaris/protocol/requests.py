"""What a program asks of the camera: `NAME:arguments` with a checksum, or `NAME arguments` without."""

import re
from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.ndi_polaris.protocol.checksum import crc_text
from truepose_drivers.stream_reader import StreamReader

_LONGEST_REQUEST = 2_048
_CRC_DIGITS = 4
_FORM = re.compile(rb"([A-Z][A-Z0-9]*)([: ]?)(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Request:
    """A command and its arguments."""

    name: str
    arguments: str = ""


@dataclass(frozen=True, slots=True)
class Damaged:
    """Characters that are no request; `too_long` and `checksum` say what is wrong, else it is no command."""

    too_long: bool = False
    checksum: bool = False


def encode_request(request: Request) -> bytes:
    """Return the characters of a request, with its checksum."""
    text = f"{request.name}:{request.arguments}".encode("ascii")
    return text + crc_text(text) + b"\r"


Asked: TypeAlias = Request | Damaged


class RequestReader(StreamReader):
    """Reassembles requests; the camera's side of the wire."""

    def next_message(self) -> Asked | None:
        """Take the oldest whole request, None until more arrives; raises RemoteProtocolError."""
        end = self._buffer.find(b"\r")
        if end < 0:
            if len(self._buffer) > 2 * _LONGEST_REQUEST:
                raise RemoteProtocolError("a request does not end: is this the right port?")
            return None
        return _read(self._take(end, drop=1))


def _read(line: bytes) -> Asked:
    if len(line) > _LONGEST_REQUEST:
        return Damaged(too_long=True)
    found = _FORM.fullmatch(line)
    if found is None or not line.isascii():
        return Damaged()
    name, mark, rest = found.groups()
    if mark == b":":
        if crc_text(line[:-_CRC_DIGITS]) != line[-_CRC_DIGITS:].upper():
            return Damaged(checksum=True)
        rest = rest[:-_CRC_DIGITS]
    return Request(name.decode("ascii"), rest.decode("ascii"))
