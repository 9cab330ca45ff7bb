"""What may go wrong in a cell; faults come from the scenario (`[[fault]]`) or over the truth endpoint."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.times import AtMove, AtReading, Lasting, from_one
from truepose_simulators.faults.wire import (
    BallbarFrozen,
    BallbarInches,
    BallbarKeyPressed,
    CameraFrozen,
    LineDoublesDigits,
    LineStalls,
    TrackerRepeatsResult,
    TrackerStaleResult,
    TrackerUnitsChanged,
    TrackerWireFault,
    WireFault,
)
from truepose_simulators.physics.arm import Vector

_WITH_SERIAL = ("tracker", "robot", "ballbar", "pose_tracker")
_LONGEST_SERIAL = 12  # the ballbar's own report has room for so many


@dataclass(frozen=True, slots=True)
class BeamBroken(AtReading):
    """Something crosses the beam during `count` stationary measurements from number `reading` on."""

    count: int = 1

    def __post_init__(self) -> None:
        from_one(self, "reading", "count")


class TrackerSilent(AtReading):
    """The tracker accepts measurement number `reading` and never says anything about it."""


class TrackerCut(AtReading):
    """The link breaks in the middle of the result of measurement number `reading`."""


class TrackerBlinded(Lasting):
    """The tracker sees no reflector at all."""


@dataclass(frozen=True, slots=True)
class SmrMissing:
    """Somebody left the reflector out of tool nest `nest`."""

    nest: int
    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class FixedNestMoved:
    """Fixed nest `nest` is knocked by `by_mm` (world frame)."""

    nest: int
    by_mm: Vector
    from_s: float = 0.0


class BallbarTooFast(Lasting):
    """The ballbar is moved faster than its transducer can count: it has no value until it counts again."""


@dataclass(frozen=True, slots=True)
class IdentityChanged:
    """From now on another `device` (one of `_WITH_SERIAL`) answers: with this serial number."""

    device: str
    serial: str  # empty: it tells none, where its protocol knows a word for that
    from_s: float = 0.0

    def __post_init__(self) -> None:
        if self.device not in _WITH_SERIAL:
            raise ScenarioError(f'key "device" must be one of {", ".join(_WITH_SERIAL)}, not {self.device!r}')
        if self.device == "tracker" and not re.fullmatch(r"[0-9]{1,9}", self.serial):  # emScon: 32 bits
            raise ScenarioError(f'key "serial" of a tracker must be up to nine digits, not {self.serial!r}')
        if not (self.serial.isascii() and len(self.serial) <= _LONGEST_SERIAL):
            raise ScenarioError(f'key "serial" must be at most {_LONGEST_SERIAL} plain characters')


class RobotRefuses(AtMove):
    """The controller stops its program at move number `move`, as it does for a target out of range."""


class RobotHangs(AtMove):
    """The arm moves to the target of move number `move`, but the reply never comes."""


Fault: TypeAlias = (
    BeamBroken
    | TrackerSilent
    | TrackerCut
    | TrackerBlinded
    | SmrMissing
    | FixedNestMoved
    | BallbarTooFast
    | IdentityChanged
    | RobotRefuses
    | RobotHangs
    | WireFault
    | TrackerWireFault
)
ReadingFault: TypeAlias = BeamBroken | TrackerSilent | TrackerCut | TrackerWireFault
MoveFault: TypeAlias = RobotRefuses | RobotHangs

KINDS: Mapping[str, type[Fault]] = MappingProxyType({
    "beam_broken": BeamBroken,
    "tracker_silent": TrackerSilent,
    "tracker_cut": TrackerCut,
    "tracker_blinded": TrackerBlinded,
    "smr_missing": SmrMissing,
    "fixed_nest_moved": FixedNestMoved,
    "ballbar_too_fast": BallbarTooFast,
    "identity_changed": IdentityChanged,
    "ballbar_frozen": BallbarFrozen,
    "ballbar_inches": BallbarInches,
    "ballbar_key_pressed": BallbarKeyPressed,
    "camera_frozen": CameraFrozen,
    "line_stalls": LineStalls,
    "line_doubles_digits": LineDoublesDigits,
    "tracker_units_changed": TrackerUnitsChanged,
    "tracker_repeats_result": TrackerRepeatsResult,
    "tracker_stale_result": TrackerStaleResult,
    "robot_refuses": RobotRefuses,
    "robot_hangs": RobotHangs,
})


def check_nest(fault: Fault, *, tool_nests: int, fixed_nests: int) -> None:
    """Raise ScenarioError when a fault is about a nest that the cell does not have."""
    match fault:
        case SmrMissing(nest=nest):
            known = tool_nests
        case FixedNestMoved(nest=nest):
            known = fixed_nests
        case _:
            return
    if not 1 <= nest <= known:
        raise ScenarioError(f'key "nest" must be 1 to {known}, not {nest}')
