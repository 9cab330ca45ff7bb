"""Wire protocol of NDI's optical trackers (combined API of Polaris and Vega): bytes in, messages out.

Source: NDI's public API guide of the Polaris Vega as the open client `PlusToolkit/ndicapi` (MIT) speaks it.
A request is answered once; nothing comes unasked but RESET. Millimetres, quaternions q0 qx qy qz.

Replies to TX and BX, in reply mode 0001 or 0801, say where each tool was in a frame. TX writes fixed digits
(a quaternion to 1e-4, a position to 0.01 mm, an error to 1e-4 mm), BX single floats.
"""

import math
import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntFlag
from itertools import pairwise
from typing import TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

# The checksum of every request and reply: x^16 + x^15 + x^2 + 1, reflected, from 0.
_POLYNOMIAL = 0xA001


def _table_entry(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (_POLYNOMIAL if byte & 1 else 0)
    return byte


_TABLE = tuple(map(_table_entry, range(256)))


def crc16(data: bytes | bytearray) -> int:
    """Return the checksum of `data`; of data with its own checksum behind it, low byte first, it is 0."""
    crc = 0
    for byte in data:
        crc = (crc >> 8) ^ _TABLE[(crc ^ byte) & 0xFF]
    return crc


def crc_text(data: bytes) -> bytes:
    """Return the checksum as it stands behind text: four upper-case digits."""
    return b"%04X" % crc16(data)


DEFAULT_PORT = 8765
_LONGEST_REQUEST = 2_048
_CRC_DIGITS = 4
_FORM = re.compile(rb"([A-Z][A-Z0-9]*)([: ]?)(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Request:
    """A command and its arguments."""

    name: str
    arguments: str = ""


@dataclass(frozen=True, slots=True)
class DamagedRequest:
    """Characters that are no request; `too_long` and `checksum` say what is wrong, else it is no command."""

    too_long: bool = False
    checksum: bool = False


def encode_request(request: Request) -> bytes:
    """Return the characters of a request, with its checksum."""
    text = f"{request.name}:{request.arguments}".encode("ascii")
    return text + crc_text(text) + b"\r"


ReceivedRequest: TypeAlias = Request | DamagedRequest


class RequestReader(StreamReader):
    """Reassembles requests; the camera's side of the wire."""

    def next_message(self) -> ReceivedRequest | None:
        """Take the oldest whole request, None until more arrives; raises RemoteProtocolError."""
        end = self._buffer.find(b"\r")
        if end < 0:
            # Twice the longest: a request that is only too long is whole when it ends, and is refused with
            # error 02.
            if len(self._buffer) > 2 * _LONGEST_REQUEST:
                raise RemoteProtocolError("a request does not end: is this the right port?")
            return None
        return _read(self._take(end, drop=1))


def _read(line: bytes) -> ReceivedRequest:
    if len(line) > _LONGEST_REQUEST:
        return DamagedRequest(too_long=True)
    found = _FORM.fullmatch(line)
    if found is None or not line.isascii():
        return DamagedRequest()
    name, mark, rest = found.groups()
    # The form with a blank has no checksum.
    if mark == b":":
        if crc_text(line[:-_CRC_DIGITS]) != line[-_CRC_DIGITS:].upper():
            return DamagedRequest(checksum=True)
        rest = rest[:-_CRC_DIGITS]
    return Request(name.decode("ascii"), rest.decode("ascii"))


_BINARY_START = b"\xc4\xa5"  # 0xA5C4, low byte first
_HEAD = struct.Struct("<2sHH")  # start, length of the body, checksum of both
_CRC = struct.Struct("<H")
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
            raise NdiProtocolError("the camera's binary reply has a damaged header: connect again")
        if len(self._buffer) < _HEAD.size + length + _CRC.size:
            return None
        body = self._take(_HEAD.size + length + _CRC.size)[_HEAD.size :]
        if crc16(body) != 0:
            raise NdiProtocolError("the camera's binary reply is damaged (wrong checksum): connect again")
        return Binary(body[:length])


def _checked_text(line: bytes) -> Text:
    text, digits = line[:-_CRC_DIGITS], line[-_CRC_DIGITS:]
    if digits != crc_text(text):
        raise NdiProtocolError(f"the camera's reply {line[:40]!r} is damaged (wrong checksum): connect again")
    if not text.isascii():
        raise NdiProtocolError(f"the camera's reply {line[:40]!r} is not text: is this the right port?")
    return Text(text.decode("ascii"))


_MODEL, _SERIAL = "Features.Hardware.Model", "Features.Hardware.Serial Number"
_REVISION = " Rev "


@dataclass(frozen=True, slots=True)
class CameraIdentity:
    """Model, serial number and firmware; empty where the camera does not say."""

    model: str
    serial: str
    firmware: str


def facts(reply: Text) -> dict[str, str]:
    """Return what stands in lines of `name: value` (VER) or `name=value` (GETINFO)."""
    found: dict[str, str] = {}
    for line in reply.text.split("\n"):
        for mark in ("=", ":"):
            name, marked, value = line.partition(mark)
            if marked:
                found[name.strip()] = value.strip()
                break
    return found


def identity_of(version: Mapping[str, str], info: Mapping[str, str]) -> CameraIdentity:
    """Return who the camera is; what GETINFO says goes before what VER says."""
    model, _, revision = version.get("Freeze Tag", "").partition(_REVISION)
    return CameraIdentity(
        model=info.get(_MODEL, "") or model,
        serial=info.get(_SERIAL, "") or version.get("NDI S/N", ""),
        firmware=revision,
    )


ANY_PASSIVE_TOOL = Request("PHRQ", "*********1****")  # arguments: hardware, system, type, port, all left open
PAGE_BYTES = 64
LARGEST_DEFINITION = 1_024  # bytes of a .rom file

_HANDLE = re.compile(r"[0-9A-F]{2}")
_HANDLES = re.compile(r"([0-9A-F]{2})((?:[0-9A-F]{5})*)")
_HANDLE_ENTRY = re.compile(r"([0-9A-F]{2})([0-9A-F]{3})")


def page_writes(handle: int, definition: bytes) -> Iterator[Request]:
    """Yield the writes that load a definition, which is filled up with zeros to its largest size."""
    image = definition.ljust(LARGEST_DEFINITION, b"\0")
    for address in range(0, LARGEST_DEFINITION, PAGE_BYTES):
        page = image[address : address + PAGE_BYTES].hex().upper()
        yield Request("PVWR", f"{handle:02X}{address:04X}{page}")


def decode_handle(reply: Text) -> int:
    """Read the answer to PHRQ; raises NdiProtocolError."""
    if not _HANDLE.fullmatch(reply.text):
        raise NdiProtocolError(f"the camera answered {reply.text[:40]!r} instead of a port handle")
    return int(reply.text, 16)


def encode_handles(handles: Sequence[tuple[int, int]]) -> Text:
    """Return the answer to PHSR: handles and the low twelve bits of their status."""
    return Text(
        f"{len(handles):02X}" + "".join(f"{handle:02X}{status & 0xFFF:03X}" for handle, status in handles)
    )


def decode_handles(reply: Text) -> list[tuple[int, int]]:
    """Read the answer to PHSR: handles and status; raises NdiProtocolError."""
    found = _HANDLES.fullmatch(reply.text)
    entries = _HANDLE_ENTRY.findall(found[2]) if found else []
    if found is None or len(entries) != int(found[1], 16):
        raise NdiProtocolError(f"the camera answered {reply.text[:40]!r} instead of a list of handles")
    return [(int(handle, 16), int(status, 16)) for handle, status in entries]


_POSE = struct.Struct("<8f")
_STATE = struct.Struct("<BB")  # handle, and what follows
_PORT = struct.Struct("<II")  # port status, frame
_SYSTEM = struct.Struct("<H")
_VALID, _MISSING, _DISABLED = 1, 2, 4
_UNIT = 1e-3  # four components rounded to 1e-4 are a unit quaternion within 2e-4
_ENTRY = re.compile(
    r"([0-9A-F]{2})((?:[+-]\d{5}){4}(?:[+-]\d{6}){3}[+-]\d{5}|MISSING|DISABLED|UNOCCUPIED)"
    r"([0-9A-F]{8})([0-9A-F]{8})\n?"
)
_QUATERNION_STEP, _POSITION_STEP_MM, _ERROR_STEP_MM = 1e-4, 0.01, 1e-4


class PortStatus(IntFlag):
    """The bits of a port's status that matter to a pose."""

    TOOL_IN_PORT = 0x01
    INITIALISED = 0x10
    ENABLED = 0x20
    OUT_OF_VOLUME = 0x40
    PARTIALLY_OUT_OF_VOLUME = 0x80


_NOTHING = PortStatus(0)


@dataclass(frozen=True, slots=True)
class ToolPose:
    """A tool in the camera's frame."""

    quaternion: tuple[float, float, float, float]  # q0 qx qy qz, about a unit
    position_mm: tuple[float, float, float]
    error_mm: float  # root mean square of the fit of its markers


@dataclass(frozen=True, slots=True)
class ToolFrame:
    """What a frame says of one tool; `pose` is None where the camera did not find it."""

    handle: int
    pose: ToolPose | None
    status: PortStatus = _NOTHING
    frame: int = 0
    disabled: bool = False


def encode_binary(tools: Sequence[ToolFrame]) -> Binary:
    """Return the reply to BX."""
    entries = b"".join(map(_binary_entry, tools))
    return Binary(bytes([len(tools)]) + entries + _SYSTEM.pack(0))


def _binary_entry(tool: ToolFrame) -> bytes:
    if tool.disabled:
        return _STATE.pack(tool.handle, _DISABLED)
    port = _PORT.pack(tool.status, tool.frame)
    if tool.pose is None:
        return _STATE.pack(tool.handle, _MISSING) + port
    pose = _POSE.pack(*tool.pose.quaternion, *tool.pose.position_mm, tool.pose.error_mm)
    return _STATE.pack(tool.handle, _VALID) + pose + port


def decode_binary(reply: Binary) -> list[ToolFrame]:
    """Read the reply to BX; raises NdiProtocolError."""
    try:
        return _binary_tools(reply.body)
    except (struct.error, IndexError) as error:
        raise NdiProtocolError("the camera's frame ends in the middle of a tool: connect again") from error


def _binary_tools(body: bytes) -> list[ToolFrame]:
    tools, at = [], 1
    for _ in range(body[0]):
        handle, state = _STATE.unpack_from(body, at)
        at += _STATE.size
        pose = None
        # Neither port status nor frame follow a disabled handle.
        if state == _DISABLED:
            tools.append(ToolFrame(handle, None, disabled=True))
            continue
        if state == _VALID:
            pose = _checked(_POSE.unpack_from(body, at))
            at += _POSE.size
        elif state != _MISSING:
            raise NdiProtocolError(
                f"the camera reports {state} of a tool, which is neither valid nor missing"
            )
        status, frame = _PORT.unpack_from(body, at)
        at += _PORT.size
        tools.append(ToolFrame(handle, pose, PortStatus(status), frame))
    if at + _SYSTEM.size != len(body):
        raise NdiProtocolError(
            f"the camera's frame has {len(body)} bytes but {at + _SYSTEM.size} were expected"
        )
    return tools


def encode_text(tools: Sequence[ToolFrame]) -> Text:
    """Return the reply to TX."""
    entries = "".join(f"{tool.handle:02X}{_text_entry(tool)}\n" for tool in tools)
    return Text(f"{len(tools):02X}{entries}0000")


def _text_entry(tool: ToolFrame) -> str:
    port = f"{tool.status:08X}{tool.frame:08X}"
    if tool.pose is None:
        return ("DISABLED" if tool.disabled else "MISSING") + port
    quaternion = "".join(_digits(value, _QUATERNION_STEP, 6) for value in tool.pose.quaternion)
    position = "".join(_digits(value, _POSITION_STEP_MM, 7) for value in tool.pose.position_mm)
    return quaternion + position + _digits(tool.pose.error_mm, _ERROR_STEP_MM, 6) + port


def _digits(value: float, step: float, width: int) -> str:
    return f"{round(value / step):+0{width}d}"


def decode_text(reply: Text) -> list[ToolFrame]:
    """Read the reply to TX; raises NdiProtocolError."""
    count, rest = reply.text[:2], reply.text[2:]
    tools = []
    while found := _ENTRY.match(rest):
        tools.append(_text_tool(*found.groups()))
        rest = rest[found.end() :]
    if not re.fullmatch(r"[0-9A-F]{2}", count) or int(count, 16) != len(tools):
        raise NdiProtocolError(
            f"the camera's frame {reply.text[:40]!r} is not a list of tools: connect again"
        )
    if not re.fullmatch(r"[0-9A-F]{4}", rest):
        raise NdiProtocolError(f"the camera's frame ends in {rest[:20]!r} instead of its status")
    return tools


def _text_tool(handle: str, said: str, status: str, frame: str) -> ToolFrame:
    if not said.startswith(("+", "-")):
        pose = None
    else:
        cuts = [0, 6, 12, 18, 24, 31, 38, 45, 51]
        counts = [int(said[start:end]) for start, end in pairwise(cuts)]
        steps = [_QUATERNION_STEP] * 4 + [_POSITION_STEP_MM] * 3 + [_ERROR_STEP_MM]
        pose = _checked(tuple(count * step for count, step in zip(counts, steps, strict=True)))
    gone = said in ("DISABLED", "UNOCCUPIED")
    return ToolFrame(int(handle, 16), pose, PortStatus(int(status, 16)), int(frame, 16), disabled=gone)


def _checked(values: tuple[float, ...]) -> ToolPose:
    q0, qx, qy, qz, x, y, z, error = values
    length = math.hypot(q0, qx, qy, qz)
    if not (abs(length - 1.0) <= _UNIT and all(map(math.isfinite, (x, y, z))) and 0.0 <= error < math.inf):
        raise NdiProtocolError(
            f"the camera reports a quaternion of length {length:.4g} at {(x, y, z)} mm with error {error}:"
            " not a valid pose"
        )
    return ToolPose((q0, qx, qy, qz), (x, y, z), error)
