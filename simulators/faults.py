"""Scripted failures: what goes wrong in the cell, and when.

Faults come from the scenario (`[[fault]]`) or over the truth endpoint. `reading` and `move` count from the
moment the fault is given, so 1 is the next one; times are cell time.
"""

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from simulators.errors import ScenarioError
from simulators.physics.arm import Vector
from simulators.wire_faults import (
    BallbarFrozen,
    BallbarInches,
    BallbarKeyPressed,
    LineDoublesDigits,
    LineStalls,
    TrackerRepeatsResult,
    TrackerStaleResult,
    TrackerUnitsChanged,
    TrackerWireFault,
    WireFault,
)

_WITH_SERIAL = ("tracker", "robot", "ballbar")
_LONGEST_SERIAL = 12  # the ballbar's own report has room for so many


@dataclass(frozen=True, slots=True)
class BeamBroken:
    """Something crosses the beam during `count` stationary measurements from number `reading` on."""

    reading: int
    count: int = 1

    def __post_init__(self) -> None:
        _from_one(self, "reading", "count")


@dataclass(frozen=True, slots=True)
class TrackerSilent:
    """The tracker accepts measurement number `reading` and never says anything about it."""

    reading: int

    def __post_init__(self) -> None:
        _from_one(self, "reading")


@dataclass(frozen=True, slots=True)
class TrackerCut:
    """The link breaks in the middle of the result of measurement number `reading`."""

    reading: int

    def __post_init__(self) -> None:
        _from_one(self, "reading")


@dataclass(frozen=True, slots=True)
class TrackerBlinded:
    """The tracker sees no reflector at all."""

    from_s: float = 0.0
    until_s: float = math.inf


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


@dataclass(frozen=True, slots=True)
class BallbarTooFast:
    """The ballbar is moved faster than its transducer can count: it has no value until it counts again."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class IdentityChanged:
    """From now on another `device` ("tracker", "robot", "ballbar") answers: with this serial number."""

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


@dataclass(frozen=True, slots=True)
class RobotRefuses:
    """The controller stops its program at move number `move`, as it does for a target out of range."""

    move: int

    def __post_init__(self) -> None:
        _from_one(self, "move")


@dataclass(frozen=True, slots=True)
class RobotHangs:
    """The arm moves to the target of move number `move`, but the reply never comes."""

    move: int

    def __post_init__(self) -> None:
        _from_one(self, "move")


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
    "line_stalls": LineStalls,
    "line_doubles_digits": LineDoublesDigits,
    "tracker_units_changed": TrackerUnitsChanged,
    "tracker_repeats_result": TrackerRepeatsResult,
    "tracker_stale_result": TrackerStaleResult,
    "robot_refuses": RobotRefuses,
    "robot_hangs": RobotHangs,
})


class Faults:
    """The failures of one cell; counts its stationary measurements and moves."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []
        self._readings = 0
        self._moves = 0

    def add(self, fault: Fault) -> None:
        """Script a failure; its counts start now."""
        if isinstance(fault, ReadingFault):
            _from_one(fault, "reading")
            fault = dataclasses.replace(fault, reading=fault.reading + self._readings)
        elif isinstance(fault, MoveFault):
            fault = dataclasses.replace(fault, move=fault.move + self._moves)
        self._faults.append(fault)

    def next_reading(self) -> ReadingFault | None:
        """Count one stationary measurement and return what befalls it."""
        self._readings += 1
        scripted = (fault for fault in self._faults if isinstance(fault, ReadingFault))
        return next((fault for fault in scripted if self._readings in _readings_hit(fault)), None)

    def next_move(self) -> MoveFault | None:
        """Count one motion and return what befalls it."""
        self._moves += 1
        hits = (fault for fault in self._faults if isinstance(fault, MoveFault) and fault.move == self._moves)
        return next(hits, None)

    def blinded(self, time_s: float) -> bool:
        """Whether the tracker sees nothing."""
        return any(
            fault.from_s <= time_s < fault.until_s
            for fault in self._faults
            if isinstance(fault, TrackerBlinded)
        )

    def ballbar_too_fast(self, time_s: float) -> bool:
        """Whether the ballbar cannot count."""
        return any(
            fault.from_s <= time_s < fault.until_s
            for fault in self._faults
            if isinstance(fault, BallbarTooFast)
        )

    def serial(self, device: str, own: str, time_s: float) -> str:
        """Return with which serial number a device answers; `own` where nobody has exchanged it."""
        changes = [
            fault.serial
            for fault in self._faults
            if isinstance(fault, IdentityChanged) and fault.device == device and fault.from_s <= time_s
        ]
        return changes[-1] if changes else own

    def on_the_wire(self, kind: type[WireFault], time_s: float) -> bool:
        """Whether such a fault of a wire, or of its keys, holds."""
        return any(
            fault.from_s <= time_s < fault.until_s for fault in self._faults if isinstance(fault, kind)
        )

    def smr_missing(self, nest: int, time_s: float) -> bool:
        """Whether tool nest `nest` (1-based) is empty."""
        return any(
            fault.nest == nest and fault.from_s <= time_s < fault.until_s
            for fault in self._faults
            if isinstance(fault, SmrMissing)
        )

    def fixed_nest_shift_mm(self, nest: int, time_s: float) -> Vector:
        """By how much fixed nest `nest` (1-based) has been knocked so far [mm]."""
        shifts = [
            fault.by_mm
            for fault in self._faults
            if isinstance(fault, FixedNestMoved) and fault.nest == nest and time_s >= fault.from_s
        ]
        x, y, z = (math.fsum(shift[axis] for shift in shifts) for axis in range(3))
        return x, y, z


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


def _from_one(fault: object, *names: str) -> None:
    for name in names:
        if getattr(fault, name) < 1:
            raise ScenarioError(f'key "{name}" must be 1 or more, not {getattr(fault, name)}')


def _readings_hit(fault: ReadingFault) -> range:
    count = fault.count if isinstance(fault, BeamBroken) else 1
    return range(fault.reading, fault.reading + count)
