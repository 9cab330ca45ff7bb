"""The ballbar as a device: which balls it is between, how long it is, what its transducer shows.

Whoever asks for a sample asks at a time of the cell; truths depend on what the hands did and when, never on
how often somebody has asked.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from truepose_simulators.instruments.accuracy import BallbarSetup, snapped_zero_mm
from truepose_simulators.instruments.gauges.length_source import Sample

BarSet: TypeAlias = Literal["tool", "base"]

# What the display shows at the stops of the transducer, beyond anything within its range.
_AT_STOP = 1.05
_ENDS = 2
_AWAKE_S = 1.5  # so long a bar that was let go shows its stop before it spares its battery
# A hand that plays with the bar: mostly run out to its end, now and then through its range.
_SWAY_RANGES, _SWAY_S = 1.5, 0.8  # about twice the range, either way, and how long one to and fro takes


@dataclass(frozen=True, slots=True)
class Ball:
    """One of the balls that an end of the ballbar can sit on."""

    kind: Literal["cup", "nest"]
    number: int  # 1-based

    def __str__(self) -> str:
        return f"{'B' if self.kind == 'cup' else 'T'}{self.number}"


@dataclass(frozen=True, slots=True)
class Span:
    """Two balls that the ballbar is between."""

    first: Ball
    second: Ball
    wild_mm: float = 0.0  # by how much its readings are off, where a planted effect spoils them


@dataclass(frozen=True, slots=True)
class OnCalibrator:
    """The ballbar lies on its calibrator."""


@dataclass(frozen=True, slots=True)
class InHand:
    """The person holds the ballbar, which moves as a hand does."""


Seat: TypeAlias = Span | OnCalibrator | InHand


@dataclass(frozen=True, slots=True)
class BallbarSurroundings:
    """What the ballbar sees of its cell."""

    distance_mm: Callable[[Span, float], float]  # true, at a cell time
    error_mm: Callable[[float, int, float, float], float]  # of a length, initialisation, age [s], cell time
    temperature_c: Callable[[float], float]  # as its thermometer has it


class Ballbar:
    """State of the ballbar; knows no protocol and no unit but mm."""

    def __init__(
        self,
        setup: BallbarSetup,
        around: BallbarSurroundings,
        noise: np.random.Generator | None,
        handling: np.random.Generator | None,
    ) -> None:
        """Lie aside, plugged in, without bars; without generators readings have no noise and no snaps."""
        self.setup = setup
        self.bars: BarSet | None = None
        self.plugged = True
        self.switched_on = True
        self._around = around
        self._noise = noise
        self._handling = handling
        self._seat: Seat | None = None
        self._comes_off_s = -math.inf  # when it comes off its seat, or came off the last one
        self._offset_mm = 0.0  # of the transducer, with these bars
        self._walk_mm = 0.0  # of the zero since the last initialisation
        self._initialisation = 0
        self._initialised_s = 0.0
        self._sequence = 0

    @property
    def nominal_mm(self) -> float:
        """Nominal length with the present bars."""
        return self.setup.tool_nominal_mm if self.bars == "tool" else self.setup.nominal_mm

    def seat(self, time_s: float) -> Seat | None:
        """Return what the ballbar is on at a cell time; None while it lies aside."""
        return None if time_s >= self._comes_off_s else self._seat

    def put_on_calibrator(self, bars: BarSet, time_s: float) -> None:
        """Screw on these bars, unless they are on, and begin a new initialisation."""
        self._snap(_ENDS)
        # What the zero has walked stays in the transducer; an initialisation counts from where it is now.
        self._offset_mm += self._walk_mm
        self._walk_mm = 0.0
        # Bars that stay on keep the error with which they were screwed on.
        if bars != self.bars and self._handling is not None:
            self._offset_mm = self.setup.bars_mm * float(self._handling.standard_normal())
        self.bars = bars
        self._initialisation += 1
        self._initialised_s = time_s
        self._sit(OnCalibrator())

    def put_between(self, span: Span) -> None:
        """Sit between two balls."""
        self._snap(_ENDS)
        self._sit(span)

    def take_off(self, time_s: float) -> None:
        """Lie aside from a cell time on."""
        self._snap(1)
        self._comes_off_s = time_s

    def take_in_hand(self) -> None:
        """Be held by the person, off every ball."""
        self._snap(1)
        self._sit(InHand())

    def come_off(self, time_s: float) -> None:
        """Lose a ball at a cell time, now or later: a magnet lets go."""
        self._comes_off_s = time_s

    def sample(self, time_s: float) -> Sample:
        """Read the transducer at a cell time."""
        self._sequence += 1
        temperature_c = self._around.temperature_c(time_s)
        seat = self.seat(time_s)
        asleep = seat is None and time_s - self._comes_off_s > _AWAKE_S
        if asleep or not self.plugged or not self.switched_on:
            return Sample(math.nan, "none", self._sequence, temperature_c)
        if seat is None:  # its spring has run it out
            stop_mm = _AT_STOP * self.setup.range_mm
            return Sample(stop_mm, "out_of_range", self._sequence, temperature_c)
        shown = self._length_mm(seat, time_s) - self.nominal_mm + self._offset_mm + self._walk_mm
        if self._noise is not None:
            shown += self.setup.noise_mm * float(self._noise.standard_normal())
            shown = round(shown / self.setup.resolution_mm) * self.setup.resolution_mm
        if abs(shown) <= self.setup.range_mm:
            return Sample(shown, "good", self._sequence, temperature_c)
        stop = math.copysign(_AT_STOP * self.setup.range_mm, shown)
        return Sample(stop, "out_of_range", self._sequence, temperature_c)

    def _length_mm(self, seat: Seat, time_s: float) -> float:
        """Return the length before zero and noise; the calibrator is as long as its certificate says."""
        if isinstance(seat, OnCalibrator):
            return self.nominal_mm + self.setup.calibrator_excess_mm
        if isinstance(seat, InHand):
            sway = _SWAY_RANGES * (1.0 + math.sin(2.0 * math.pi * time_s / _SWAY_S))
            return self.nominal_mm + sway * self.setup.range_mm
        true = self._around.distance_mm(seat, time_s)
        age_s = time_s - self._initialised_s
        return true + seat.wild_mm + self._around.error_mm(true, self._initialisation, age_s, time_s)

    def _sit(self, seat: Seat) -> None:
        self._seat = seat
        self._comes_off_s = math.inf

    def _snap(self, times: int) -> None:
        if self._handling is None:
            return
        for _ in range(times):
            self._walk_mm = snapped_zero_mm(self.setup, self._walk_mm, self._handling)
