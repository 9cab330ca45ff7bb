"""The failures of one cell, as they were scripted: which wait for their trigger, which hold, what befell."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeVar

from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import (
    KINDS,
    FixedNestMoved,
    IdentityChanged,
    SmrMissing,
    TemperatureStep,
    ToolSlips,
    TrackerDrifts,
    TripodKicked,
)
from truepose_simulators.faults.times import (
    EVENTS,
    AtConnection,
    AtMove,
    AtReading,
    Fault,
    Lasting,
    ScheduledFault,
)
from truepose_simulators.physics.arm import Vector

_S_PER_H: Final = 3600.0
_NAMES: Final = {kind: name for name, kind in KINDS.items()}
_ZERO: Vector = (0.0, 0.0, 0.0)

L = TypeVar("L", bound=Lasting)
S = TypeVar("S", bound=ScheduledFault)


@dataclass(slots=True)
class ScriptedFault:
    """A fault that was given to a cell, and what has become of it."""

    number: int
    fault: Fault
    given_s: float
    counted: Mapping[str, int]  # events before it was given
    begun_s: float | None = None
    ended_s: float = math.inf
    struck_s: list[float] = field(default_factory=list)

    def began_s(self) -> float:
        """Return when its trigger came, or will come; infinite for an event that is waited for."""
        if any(getattr(self.fault, name) is not None for name in EVENTS):
            return math.inf if self.begun_s is None else self.begun_s
        later_s = self.fault.after_s if isinstance(self.fault, Lasting) else 0.0
        return max(self.fault.from_s, self.given_s) + later_s

    def over_s(self) -> float:
        """Return when it is over, or will be."""
        if isinstance(self.fault, ScheduledFault) and len(self.struck_s) == self.fault.count:
            return min(self.ended_s, self.struck_s[-1])
        if isinstance(self.fault, Lasting):
            return min(self.ended_s, self.fault.end_s(self.began_s()))
        return self.ended_s

    def state(self, time_s: float) -> str:
        """Return in one word where it stands."""
        if time_s >= self.over_s():
            return "over"
        return "active" if time_s >= self.began_s() else "waiting"

    def notice(self, event: str, number: int, now_s: float) -> None:
        """Begin where this is the event that is waited for, or a later one of its kind."""
        wanted = getattr(self.fault, event)
        if wanted is None or self.begun_s is not None or number - self.counted[event] < wanted:
            return
        self.begun_s = now_s + (self.fault.after_s if isinstance(self.fault, Lasting) else 0.0)

    def document(self, time_s: float) -> dict[str, object]:
        """Return it for whoever asks: its keys as they were given, and what has become of it."""
        stated = {
            item.name: getattr(self.fault, item.name)
            for item in dataclasses.fields(self.fault)
            if getattr(self.fault, item.name) != item.default
        }
        begun_s, over_s = self.began_s(), self.over_s()
        return {
            "number": self.number,
            "kind": _NAMES[type(self.fault)],
            "keys": stated,
            "state": self.state(time_s),
            "begun_s": begun_s if begun_s <= min(time_s, over_s) else None,
            "over_s": over_s if over_s <= time_s else None,
            "struck": len(self.struck_s),
        }


class Faults:
    """The failures of one cell; counts its stationary measurements, moves and measured stops."""

    def __init__(self, now_s: Callable[[], float] = lambda: 0.0) -> None:
        self._now_s = now_s
        self.given: list[ScriptedFault] = []
        self._counts = dict.fromkeys(EVENTS, 0)
        self._measured_at: object = None

    def add(self, fault: Fault) -> int:
        """Script a failure and return its number; its counts start now."""
        number = len(self.given) + 1
        self.given.append(ScriptedFault(number, fault, self._now_s(), dict(self._counts)))
        return number

    def end(self, number: int) -> None:
        """End a fault now, whatever it waits for; raises ScenarioError."""
        if not 1 <= number <= len(self.given):
            raise ScenarioError(f"there is no fault {number}: {len(self.given)} were given")
        given = self.given[number - 1]
        given.ended_s = min(given.ended_s, self._now_s())

    def measured_at(self, stop: object) -> None:
        """Note that something on the tool is read at a stop; the same one again is the same configuration."""
        if stop == self._measured_at:
            return
        self._measured_at = stop
        self._counts["configuration"] += 1
        self._notice("configuration", self._counts["configuration"])

    def next_reading(self) -> AtReading | None:
        """Count one stationary measurement and return what befalls it."""
        self._count("reading")
        return self._next(AtReading)

    def next_move(self) -> AtMove | None:
        """Count one motion and return what befalls it."""
        # A fault of the nth configuration begins with the motion to it, when nothing has been read there yet.
        self._notice("configuration", self._counts["configuration"] + 1, before_reading=True)
        self._count("move")
        return self._next(AtMove)

    def next_connection(self) -> AtConnection | None:
        """Return what befalls the hands that connect two balls now."""
        return self._next(AtConnection)

    def holding(self, kind: type[L], time_s: float) -> Iterator[tuple[L, ScriptedFault]]:
        """Yield the faults of this kind that hold at a cell time."""
        for given in self.given:
            if isinstance(given.fault, kind) and given.began_s() <= time_s < given.over_s():
                yield given.fault, given

    def holds(self, kind: type[Lasting], time_s: float) -> bool:
        """Whether a fault of this kind holds at a cell time."""
        return any(True for _ in self.holding(kind, time_s))

    def begins_s(self, kind: type[Lasting], until_s: float) -> float:
        """Return when the first fault of this kind holds from now on, `until_s` at the latest."""
        now_s = self._now_s()
        left = [given for given in self.given if isinstance(given.fault, kind) and given.over_s() > now_s]
        return min([until_s, *(max(now_s, given.began_s()) for given in left)])

    def serial(self, device: str, own: str, time_s: float) -> str:
        """Return with which serial number a device answers; `own` where nobody has exchanged it."""
        changes = [
            fault.serial for fault, _ in self.holding(IdentityChanged, time_s) if fault.device == device
        ]
        return changes[-1] if changes else own

    def smr_missing(self, nest: int, time_s: float) -> bool:
        """Whether tool nest `nest` (1-based) is empty."""
        return any(fault.nest == nest for fault, _ in self.holding(SmrMissing, time_s))

    def fixed_nest_shift_mm(self, nest: int, time_s: float) -> Vector:
        """By how much fixed nest `nest` (1-based) has been knocked so far [mm]."""
        return _sum(fault.by_mm for fault, _ in self.holding(FixedNestMoved, time_s) if fault.nest == nest)

    def tool_shift_mm(self, time_s: float) -> Vector:
        """By how much the tool has slipped [mm, flange frame]."""
        return _sum(fault.by_mm for fault, _ in self.holding(ToolSlips, time_s))

    def warming_k(self, time_s: float) -> float:
        """By how much the air is warmer [K]."""
        return math.fsum(fault.by_k for fault, _ in self.holding(TemperatureStep, time_s))

    def tracker_motion(self, time_s: float) -> tuple[float, ...]:
        """Motion of the tracker's frame about the world's origin [mm, rad], 6 numbers."""
        kicks = [fault for fault, _ in self.holding(TripodKicked, time_s)]
        drifted = (_drifted_mm(given, time_s) for given in self.given)
        return (*_sum([*(kick.by_mm for kick in kicks), *drifted]), *_sum(kick.turned_rad for kick in kicks))

    @property
    def moves_frames(self) -> bool:
        """Whether anything about tracker, tool or air may be elsewhere by a fault."""
        moving = TripodKicked | TrackerDrifts | ToolSlips | TemperatureStep
        return any(isinstance(given.fault, moving) for given in self.given)

    def _count(self, event: str) -> None:
        self._counts[event] += 1
        self._notice(event, self._counts[event])

    def _notice(self, event: str, number: int, *, before_reading: bool = False) -> None:
        now_s = self._now_s()
        for given in self.given:
            # What befalls a reading waits for it: the motion may be a second one to the stop before.
            if not (before_reading and isinstance(given.fault, AtReading | AtConnection)):
                given.notice(event, number, now_s)

    def _next(self, kind: type[S]) -> S | None:
        now_s = self._now_s()
        for given in self.given:
            if isinstance(given.fault, kind) and given.state(now_s) == "active":
                given.struck_s.append(now_s)
                return given.fault
        return None


def _drifted_mm(given: ScriptedFault, time_s: float) -> Vector:
    if not isinstance(given.fault, TrackerDrifts):
        return _ZERO
    hours = max(0.0, min(time_s, given.over_s()) - given.began_s()) / _S_PER_H
    x, y, z = (rate * hours for rate in given.fault.mm_per_h)
    return x, y, z


def _sum(vectors: Iterator[Vector] | list[Vector]) -> Vector:
    x, y, z = (math.fsum(axis) for axis in zip(_ZERO, *vectors, strict=True))
    return x, y, z
