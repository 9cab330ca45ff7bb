"""The failures of one cell, as they were scripted.

`reading` and `move` count from the moment the fault is given, so 1 is the next one; times are cell time.
"""

import dataclasses
import math

from truepose_simulators.faults.kinds import (
    BeamBroken,
    Fault,
    FixedNestMoved,
    IdentityChanged,
    MoveFault,
    ReadingFault,
    SmrMissing,
)
from truepose_simulators.faults.times import Lasting
from truepose_simulators.physics.arm import Vector


class Faults:
    """The failures of one cell; counts its stationary measurements and moves."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []
        self._readings = 0
        self._moves = 0

    def add(self, fault: Fault) -> None:
        """Script a failure; its counts start now."""
        if isinstance(fault, ReadingFault):
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

    def holds(self, kind: type[Lasting], time_s: float) -> bool:
        """Whether a fault of this kind holds at a cell time."""
        return any(fault.holds(time_s) for fault in self._faults if isinstance(fault, kind))

    def serial(self, device: str, own: str, time_s: float) -> str:
        """Return with which serial number a device answers; `own` where nobody has exchanged it."""
        changes = [
            fault.serial
            for fault in self._faults
            if isinstance(fault, IdentityChanged) and fault.device == device and fault.from_s <= time_s
        ]
        return changes[-1] if changes else own

    def bring_back(self, device: str) -> None:
        """End every exchange of a device: its own serial number answers again."""
        self._faults = [
            fault
            for fault in self._faults
            if not (isinstance(fault, IdentityChanged) and fault.device == device)
        ]

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


def _readings_hit(fault: ReadingFault) -> range:
    count = fault.count if isinstance(fault, BeamBroken) else 1
    return range(fault.reading, fault.reading + count)
