"""What may go wrong in a cell and on its wires, by the names of files and requests (docs/faults.md)."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TypeAlias

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.times import AtConnection, AtMove, AtReading, Fault, Lasting
from truepose_simulators.physics.arm import Vector

_WITH_LINK = ("tracker", "robot", "ballbar", "pose_tracker", "clock")


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkFault(Lasting):
    """Something about all connections of `device`, its further ports included."""

    device: str

    def __post_init__(self) -> None:
        Lasting.__post_init__(self)
        if self.device not in _WITH_LINK:
            raise ScenarioError(f'key "device" must be one of {", ".join(_WITH_LINK)}, not {self.device!r}')


class LinkCut(LinkFault):
    """Connections break, and new ones are hung up on."""


class LinkHalfOpen(LinkFault):
    """Connections stay, and every word on them is lost, either way."""


class BallbarFrozen(Lasting):
    """The ballbar's electronics hang: value and count stay as they were."""


class BallbarInches(Lasting):
    """Somebody switched the gauge to inches, where its protocol has them."""


class BallbarKeyPressed(Lasting):
    """Somebody presses the key that sends a value, before each question to the gauge."""


class LineStalls(Lasting):
    """The lines of counter and robot stall for 50 ms in the middle of every answer."""


class LineDoublesDigits(Lasting):
    """The gauge's line delivers the first digit of every value twice."""


class CameraFrozen(Lasting):
    """The camera hangs: it answers, and states the same frame again and again."""


class TrackerUnitsChanged(AtReading):
    """Another program sets inches during a measurement; announced where asked for."""


class TrackerRepeatsResult(AtReading):
    """A measurement is answered with the result of the one before."""


class TrackerStaleResult(AtReading):
    """The result of the measurement before comes once more, just before the next one is accepted."""


WireFault: TypeAlias = (
    BallbarFrozen | BallbarInches | BallbarKeyPressed | LineStalls | LineDoublesDigits | CameraFrozen
)


_WITH_SERIAL = ("tracker", "robot", "ballbar", "pose_tracker")
_LONGEST_SERIAL = 12  # the ballbar's own report has room for so many
_NO_VECTOR: Vector = (0.0, 0.0, 0.0)


class BeamBroken(AtReading):
    """Something crosses the beam during a stationary measurement."""


class TrackerSilent(AtReading):
    """The tracker accepts a measurement and never says anything about it."""


class TrackerCut(AtReading):
    """The link breaks in the middle of the result of a measurement."""


class TrackerBlinded(Lasting):
    """Tracker and camera see nothing at all."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TripodKicked(Lasting):
    """The tracker's frame moves by this, about the world's origin; until the end it stays there."""

    by_mm: Vector = _NO_VECTOR
    turned_rad: Vector = _NO_VECTOR


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerDrifts(Lasting):
    """The tracker's frame creeps along the axes of the world; at the end it stays where it is."""

    mm_per_h: Vector


@dataclass(frozen=True, slots=True)
class SmrMissing(Lasting):
    """Somebody left the reflector out of tool nest `nest`."""

    nest: int


@dataclass(frozen=True, slots=True)
class FixedNestMoved(Lasting):
    """Fixed nest `nest` is knocked by `by_mm` (world frame)."""

    nest: int
    by_mm: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class ToolSlips(Lasting):
    """The tool sits elsewhere on the flange by this (flange frame)."""

    by_mm: Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class TemperatureStep(Lasting):
    """Somebody opened the door: the air is warmer by this."""

    by_k: float


class BallbarTooFast(Lasting):
    """The ballbar is moved faster than its transducer can count: it has no value until it counts again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BallbarZeroJumps(Lasting):
    """The gauge shows more by this: it was dropped, or its zero was set."""

    by_mm: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongCup(AtConnection):
    """The person puts the ballbar on cup `cup` of the base, whatever was asked for."""

    cup: int


@dataclass(frozen=True, slots=True)
class IdentityChanged(Lasting):
    """From now on another `device` (one of `_WITH_SERIAL`) answers: with this serial number."""

    device: str
    serial: str  # empty: it tells none, where its protocol knows a word for that

    def __post_init__(self) -> None:
        Lasting.__post_init__(self)
        if self.device not in _WITH_SERIAL:
            raise ScenarioError(f'key "device" must be one of {", ".join(_WITH_SERIAL)}, not {self.device!r}')
        if self.device == "tracker" and not re.fullmatch(r"[0-9]{1,9}", self.serial):  # emScon: 32 bits
            raise ScenarioError(f'key "serial" of a tracker must be up to nine digits, not {self.serial!r}')
        if not (self.serial.isascii() and len(self.serial) <= _LONGEST_SERIAL):
            raise ScenarioError(f'key "serial" must be at most {_LONGEST_SERIAL} plain characters')


class RobotRefuses(AtMove):
    """The controller stops its program at a motion, as it does for a target out of range."""


class RobotHangs(AtMove):
    """The arm moves to its target, but the reply never comes."""


class ArmStopped(Lasting):
    """The arm stops where it is, its program ends, and none moves it while this holds."""


class EmergencyStop(ArmStopped):
    """Somebody presses the emergency stop."""


class ProtectiveStop(ArmStopped):
    """The controller stops by itself: a collision, a fence, a limit of its safety configuration."""


KINDS: Mapping[str, type[Fault]] = MappingProxyType({
    "beam_broken": BeamBroken,
    "tracker_silent": TrackerSilent,
    "tracker_cut": TrackerCut,
    "tracker_blinded": TrackerBlinded,
    "tripod_kicked": TripodKicked,
    "tracker_drifts": TrackerDrifts,
    "smr_missing": SmrMissing,
    "fixed_nest_moved": FixedNestMoved,
    "tool_slips": ToolSlips,
    "temperature_step": TemperatureStep,
    "ballbar_too_fast": BallbarTooFast,
    "ballbar_zero_jumps": BallbarZeroJumps,
    "wrong_cup": WrongCup,
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
    "emergency_stop": EmergencyStop,
    "protective_stop": ProtectiveStop,
    "link_cut": LinkCut,
    "link_half_open": LinkHalfOpen,
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
