"""Scripted failures of wires, keys and other programs: what a driver must not take for a reading.

Times are cell time; `reading` counts stationary measurements from the moment the fault is given.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class BallbarFrozen:
    """The ballbar's electronics hang: value and count stay as they were."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class BallbarInches:
    """Somebody switched the gauge to inches, where its protocol has them."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class BallbarKeyPressed:
    """Somebody presses the key that sends a value, before each question to the gauge."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class LineStalls:
    """The lines of counter and robot stall for 50 ms in the middle of every answer."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class LineDoublesDigits:
    """The gauge's line delivers the first digit of every value twice."""

    from_s: float = 0.0
    until_s: float = math.inf


@dataclass(frozen=True, slots=True)
class TrackerUnitsChanged:
    """Another program sets inches during measurement number `reading`; announced where asked for."""

    reading: int


@dataclass(frozen=True, slots=True)
class TrackerRepeatsResult:
    """Measurement number `reading` is answered with the result of the one before."""

    reading: int


@dataclass(frozen=True, slots=True)
class TrackerStaleResult:
    """The result of the measurement before comes once more, just before number `reading` is accepted."""

    reading: int


WireFault: TypeAlias = BallbarFrozen | BallbarInches | BallbarKeyPressed | LineStalls | LineDoublesDigits
TrackerWireFault: TypeAlias = TrackerUnitsChanged | TrackerRepeatsResult | TrackerStaleResult
