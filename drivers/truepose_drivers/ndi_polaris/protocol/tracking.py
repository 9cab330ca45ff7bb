"""Replies to TX and BX in reply mode 0001 or 0801: where each tool was in a frame.

TX writes fixed digits (a quaternion to 1e-4, a position to 0.01 mm, an error to 1e-4 mm), BX single floats.
"""

import math
import re
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntFlag
from itertools import pairwise

from truepose_drivers.ndi_polaris.protocol.replies import Binary, NdiProtocolError, Text

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


def encode_binary(tools: Sequence[ToolFrame], system_status: int = 0) -> Binary:
    """Return the reply to BX."""
    entries = b"".join(map(_binary_entry, tools))
    return Binary(bytes([len(tools)]) + entries + _SYSTEM.pack(system_status))


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
        if state == _DISABLED:
            tools.append(ToolFrame(handle, None, disabled=True))
            continue
        if state == _VALID:
            pose = _checked(_POSE.unpack_from(body, at))
            at += _POSE.size
        elif state != _MISSING:
            raise NdiProtocolError(f"the camera states {state} of a tool, which is neither valid nor missing")
        status, frame = _PORT.unpack_from(body, at)
        at += _PORT.size
        tools.append(ToolFrame(handle, pose, PortStatus(status), frame))
    if at + _SYSTEM.size != len(body):
        raise NdiProtocolError(f"the camera's frame has {len(body)} bytes where {at + _SYSTEM.size} were due")
    return tools


def encode_text(tools: Sequence[ToolFrame], system_status: int = 0) -> Text:
    """Return the reply to TX."""
    entries = "".join(f"{tool.handle:02X}{_text_entry(tool)}\n" for tool in tools)
    return Text(f"{len(tools):02X}{entries}{system_status:04X}")


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
        raise NdiProtocolError(f"the camera's frame {reply.text[:40]!r} is no list of tools: connect again")
    if not re.fullmatch(r"[0-9A-F]{4}", rest):
        raise NdiProtocolError(f"the camera's frame ends in {rest[:20]!r} where its status was due")
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
    if not (abs(length - 1.0) <= _UNIT and all(map(math.isfinite, (x, y, z))) and error >= 0.0):
        raise NdiProtocolError(
            f"the camera states a quaternion of length {length:.4g} at {(x, y, z)} mm with error {error}:"
            " that is no pose"
        )
    return ToolPose((q0, qx, qy, qz), (x, y, z), error)
