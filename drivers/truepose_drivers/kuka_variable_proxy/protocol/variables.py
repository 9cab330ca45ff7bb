"""The controller's variables that matter here, and how KRL writes their values.

Angles in degrees as the controller counts its axes. The last ones are those of our own program.
"""

import math
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose_drivers.kuka_variable_proxy.protocol.frames import ProxyProtocolError

JOINTS: Final = 6
STEP_DEG: Final = 2.0**-15  # of a REAL, which has 24 bits, at 256 to 512 deg
SILENCE_S: Final = 0.8  # without a new beat, after which our program stops the arm
BEAT_S: Final = 0.05  # so often the driver gives one
STOPS_WITHIN_S: Final = 1.0  # silence and deceleration
ACTIVE: Final = "#P_ACTIVE"  # state of a program that runs
_AXES: Final = (*(f"A{axis}" for axis in range(1, 7)), *(f"E{axis}" for axis in range(1, 7)))
_FURTHEST_DEG: Final = 3600.0  # no joint is wound up further
_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_FIELD: Final = re.compile(rf"\s*(\w+)\s+({_NUMBER}|#\w+)\s*", re.ASCII)
_AGGREGATE: Final = re.compile(r"\s*\{(?:\s*(\w+)\s*:)?([^{}]*)\}\s*", re.ASCII)
_LARGEST_COUNT: Final = 2**30
_STATE_TYPE: Final = "TP_STATE_TYPE"
_STATES: Final = ("BEGUN", "ARRIVED", "GIVEN_UP", "REFUSED")


class Variable(StrEnum):
    """Names of variables."""

    PING = "PING"  # of the proxy itself
    AXES = "$AXIS_ACT"
    OVERRIDE = "$OV_PRO"
    PROGRAM_STATE = "$PRO_STATE1"  # of the program that moves the arm
    MODE = "$MODE_OP"
    DRIVES = "$PERI_RDY"
    SERIAL = "$KR_SERIALNO"
    MODEL = "$MODEL_NAME[]"
    SOFTWARE = "$RCV_INFO[]"
    TARGET = "TP_TARGET"
    PERCENT = "TP_PERCENT"
    MOST_OVERRIDE = "TP_OVERRIDE"
    NUMBER = "TP_NUMBER"
    BEAT = "TP_BEAT"
    STATE = "TP_STATE"


@dataclass(frozen=True, slots=True)
class ProgramState:
    """Numbers of the motions that our program did this with last."""

    begun: int
    arrived: int  # at rest at the target
    given_up: int  # because nothing was heard
    refused: int  # because the target is out of the ranges of the axes

    @property
    def moves(self) -> bool:
        """Whether a motion has begun and not ended."""
        return self.begun not in {self.arrived, self.given_up, self.refused}

    @property
    def unused_number(self) -> int:
        """A number that no motion has had lately."""
        return following(max(self.begun, self.arrived, self.given_up, self.refused))


def following(count: int) -> int:
    """Return the count after `count`, from 1 on and well within 32 bits."""
    return max(count, 0) % _LARGEST_COUNT + 1


def encode_real(value: float) -> str:
    """Return a REAL as KRL shows it: with all digits that its 24 bits have, and a point."""
    (rounded,) = struct.unpack("f", struct.pack("f", value))
    text = f"{rounded + 0.0:.9G}"
    return text if "." in text or "E" in text else f"{text}.0"


def encode_axes(axes_deg: Sequence[float], kind: str = "") -> str:
    """Return an E6AXIS; raises ValueError for angles that are out of any robot's range."""
    if not all(abs(angle) <= _FURTHEST_DEG for angle in axes_deg):
        raise ValueError(f"joint angles {tuple(axes_deg)} deg are out of any robot's range")
    return encode_aggregate(dict(zip(_AXES, map(encode_real, axes_deg), strict=False)), kind)


def decode_axes(text: str) -> tuple[float, ...]:
    """Return the twelve axes of an E6AXIS, or as many as are stated; raises ProxyProtocolError."""
    fields = decode_aggregate(text, "E6AXIS")
    names = tuple(fields)
    if len(names) < JOINTS or names != _AXES[: len(names)]:
        raise ProxyProtocolError(f"the robot states {text[:160]!r}; the axes A1 to A6 were expected")
    angles = tuple(_number(value) for value in fields.values())
    if not all(abs(angle) <= _FURTHEST_DEG for angle in angles):
        raise ProxyProtocolError(f"the robot states {text[:160]!r}, which is out of any robot's range")
    return angles


def encode_state(state: ProgramState) -> str:
    """Return the state of our program."""
    counts = (state.begun, state.arrived, state.given_up, state.refused)
    return encode_aggregate(dict(zip(_STATES, map(str, counts), strict=True)), _STATE_TYPE)


def decode_state(text: str) -> ProgramState:
    """Return the state of our program; raises ProxyProtocolError."""
    fields = decode_aggregate(text, _STATE_TYPE)
    if tuple(fields) != _STATES:
        raise ProxyProtocolError(f"the robot states {text[:160]!r} as the state of the program TRUEPOSE")
    return ProgramState(*(decode_count(value) for value in fields.values()))


def decode_count(text: str) -> int:
    """Return a whole number that is not negative; raises ProxyProtocolError."""
    if not (text.isascii() and text.isdigit()) or int(text) > _LARGEST_COUNT:
        raise ProxyProtocolError(f"the robot states {text[:40]!r}; a count was expected")
    return int(text)


def decode_text(text: str) -> str:
    """Return the text of a CHAR array, or any other value as it is written."""
    return text.strip().strip('"').strip()


def encode_aggregate(fields: Mapping[str, str], kind: str = "") -> str:
    """Return a structure, with its kind in front where one is given."""
    content = ", ".join(f"{name} {value}" for name, value in fields.items())
    return f"{{{kind}: {content}}}" if kind else f"{{{content}}}"


def decode_aggregate(text: str, kind: str) -> dict[str, str]:
    """Return the fields of a structure of a kind; raises ProxyProtocolError."""
    found = _AGGREGATE.fullmatch(text)
    fields = [] if found is None else [_FIELD.fullmatch(field) for field in found[2].split(",")]
    if found is None or found[1] not in {None, kind} or None in fields:
        raise ProxyProtocolError(f"the robot states {text[:160]!r}; {kind} was expected")
    values = {field[1]: field[2] for field in fields if field is not None}
    if len(values) != len(fields):
        raise ProxyProtocolError(f"the robot states a field twice: {text[:160]!r}")
    return values


def _number(text: str) -> float:
    value = math.nan if text.startswith("#") else float(text)
    if not math.isfinite(value):
        raise ProxyProtocolError(f"the robot states {text!r}; a number was expected")
    return value
