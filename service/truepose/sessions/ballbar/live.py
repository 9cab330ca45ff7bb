"""The length as it is now, over a link that may be pulled and come back."""

import asyncio
import math
from collections import deque
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from truepose.sessions.engine.identity_check import reported_serial_number
from truepose_drivers.api import Ballbar, BallbarReading, Clock, DeviceIdentity
from truepose_drivers.errors import ConnectionLostError, DriverError, DriverFaultError, LinkError

LiveState: TypeAlias = Literal["in_range", "out_low", "out_high", "unstable", "no_signal"]
Seen: TypeAlias = Literal["connected", "in_hand", "off", "unknown"]  # what is known of the ballbar
WhyNot: TypeAlias = Literal["no_length_here", "no_signal", "out_low", "out_high", "unstable"]

# The ballbar of the thesis read up to 0.025 mm beyond its range (section 3.6): a good signal counts so far.
BEYOND_RANGE_MM: Final = 0.05
_FEWEST: Final = 3  # samples that can show a scatter at all
_SURE: Final = 8  # differences from the mean from which a scatter can be judged; two samples differ by chance
_ROUNDING_S: Final = 1e-6  # twenty steps of 0.05 s are a second


@dataclass(frozen=True, slots=True)
class LiveSample:
    """One sample with what follows from it."""

    time_s: float  # cell clock
    length_mm: float | None  # None without a signal, or without a zero to count from
    deviation_mm: float | None  # as the ballbar shows it; None without a signal
    state: LiveState
    stable_share: float  # how much of the time that it must stand still has passed, 0 to 1
    spread_mm: float | None  # twice the standard deviation since it stands still
    robot_still: bool
    sampled_at_ms: int  # wall clock, when the driver had it
    ballbar: Seen = "unknown"
    reason_needed: bool = False  # to confirm that the ballbar is off: nothing is known of it
    can_store: bool = False  # by the button
    why_not: WhyNot | None = None  # where it cannot be stored
    let_go: bool = True  # since a length was last taken; else a stored length is put to a person


class Window:
    """The samples since the length stands still, at most as many as must be looked at.

    It stands still while twice the standard deviation stays below a limit. Their range would grow with
    their number, and a slow drift by d over the window shows as d / sqrt(3).
    """

    def __init__(self, stable_s: float, stable_mm: float) -> None:
        self._stable_s = stable_s
        self._stable_mm = stable_mm
        self._samples: deque[tuple[float, float]] = deque()  # time [s], deviation [mm]
        self._moved = False  # it moved since it was last seen to stand still, or to appear

    def clear(self) -> None:
        """Begin anew."""
        self._samples.clear()
        self._moved = False

    def add(self, time_s: float, deviation_mm: float) -> None:
        """Take the next sample; what it does not agree with is dropped."""
        if self._samples and time_s < self._samples[-1][0]:
            self.clear()  # the cell's clock began anew
        self._samples.append((time_s, deviation_mm))
        # From the oldest on: a bar that has just come to rest drops the samples of its motion one by one, and
        # is stable as soon as what is left agrees.
        while self.spread_mm > self._stable_mm:
            self._samples.popleft()
            self._moved = True
        # No longer window than asked for: over minutes a slow drift would spoil a length that has stood still
        # for long enough.
        while len(self._samples) > _FEWEST and self._samples[1][0] <= time_s - self._stable_s + _ROUNDING_S:
            self._samples.popleft()
        if self.stable:
            self._moved = False

    @property
    def count(self) -> int:
        """Number of samples."""
        return len(self._samples)

    @property
    def mean_mm(self) -> float:
        """Their mean; NaN where there are none."""
        count = len(self._samples)
        return sum(value for _, value in self._samples) / count if count else math.nan

    @property
    def spread_mm(self) -> float:
        """Twice their standard deviation; of a few samples as if the missing ones agreed with their mean."""
        count = len(self._samples)
        if count < 2:
            return 0.0
        mean = self.mean_mm
        squares = sum((value - mean) ** 2 for _, value in self._samples)
        return 2.0 * math.sqrt(squares / max(count - 1, _SURE))

    @property
    def share(self) -> float:
        """How much of the time has passed for which it must stand still, 0 to 1."""
        if not self._samples:
            return 0.0
        span_s = self._samples[-1][0] - self._samples[0][0]
        return min(1.0, (span_s + _ROUNDING_S) / self._stable_s)

    @property
    def stable(self) -> bool:
        """Whether it has stood still for long enough."""
        return len(self._samples) >= _FEWEST and self.share >= 1.0

    @property
    def unsteady(self) -> bool:
        """Whether it moves, rather than being there for too short a time."""
        return self._moved and not self.stable


def is_usable(reading: BallbarReading | None) -> bool:
    """Whether a reading says a length."""
    return reading is not None and reading.signal == "good" and math.isfinite(reading.deviation_mm)


def live_state(
    reading: BallbarReading | None, off_nominal_mm: float | None, range_mm: float, *, unsteady: bool
) -> LiveState:
    """Return what to show: `off_nominal_mm` is the length against the nominal one, where it is known."""
    if reading is None or reading.signal == "none" or not math.isfinite(reading.deviation_mm):
        return "no_signal"
    off = reading.deviation_mm if off_nominal_mm is None else off_nominal_mm
    # Which end it is at is told by the length, also where the bar itself says only that it is out.
    if reading.signal == "out_of_range" or abs(off) > range_mm + BEYOND_RANGE_MM:
        return "out_high" if off > 0 else "out_low"
    return "unstable" if unsteady else "in_range"


_FIRST_WAIT_S: Final = 0.25
_LONGEST_WAIT_S: Final = 4.0


class Gauge:
    """Reads the ballbar and opens its link anew, after waits that grow, when it is lost."""

    def __init__(self, ballbar: Ballbar, clock: Clock) -> None:
        self._ballbar = ballbar
        self._clock = clock
        self._wait_s = _FIRST_WAIT_S
        self._try_again_s: float | None = None
        self.trouble: str | None = None  # why there is no reading
        self._turn = asyncio.Lock()  # one question at a time
        self.identity: DeviceIdentity | None = None  # as it last said itself; None before it did
        self.lost_power = False  # it was gone: its zero may be gone with it

    @property
    def serial(self) -> str:
        """Its serial number, empty where it tells none."""
        return "" if self.identity is None else reported_serial_number(self.identity.serial)

    async def read(self, *, ask: bool = False) -> BallbarReading | None:
        """Return the newest reading, None while there is none; `ask` it first who it is."""
        try:
            # Polls and questions come from several tasks, and not every protocol says which question an
            # answer is to.
            async with self._turn:
                if not self._ballbar.connected:
                    if not await self._connect():
                        return None
                # Behind a bridge, a counter or a radio a bar may be exchanged while the link stays up
                # (decision 0020).
                elif ask:
                    self.identity = await self._ballbar.identify()
                reading = await self._ballbar.read()
        except DriverError as error:
            await self._give_up(error)
            return None
        self.trouble = None
        self._wait_s = _FIRST_WAIT_S
        return reading

    async def ask(self) -> None:
        """Ask again who it is; raises DriverError."""
        try:
            async with self._turn:
                self.identity = await self._ballbar.identify()
        except DriverError as error:
            await self._give_up(error)
            raise

    async def close(self) -> None:
        """Close the link."""
        await self._ballbar.close()

    async def _connect(self) -> bool:
        """Open the link where the wait is over; returns whether it is open. Raises DriverError."""
        if self._try_again_s is not None:
            left_s = self._try_again_s - await self._clock.now_s()
            if 0.0 < left_s <= _LONGEST_WAIT_S:  # more is left only where the cell's clock began anew
                return False
        await self._ballbar.connect()
        self.identity = await self._ballbar.identify()
        self._try_again_s = None
        return True

    async def _give_up(self, error: DriverError) -> None:
        self.trouble = str(error)
        # a counter that falls silent keeps its zero; a gauge that vanishes has lost its supply, and what was
        # behind a driver's own failure nobody knows
        self.lost_power |= isinstance(error, ConnectionLostError | DriverFaultError)
        # A refusal is an answer over a link that works.
        if isinstance(error, LinkError) or not self._ballbar.connected:
            await self._ballbar.close()
        self._try_again_s = await self._clock.now_s() + self._wait_s
        # A pulled cable is tried every few seconds: a person who plugs it in again waits no longer than that.
        self._wait_s = min(2.0 * self._wait_s, _LONGEST_WAIT_S)
