"""The ballbar as the session follows it: samples for whoever watches, and lengths ready to be kept."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from typing import Final

from truepose.domain.ballbar import BallbarPlan, BallbarStep, LengthTaken, StepKind
from truepose.domain.cell import Artefact, BallbarKit, Bars
from truepose.messages.message import Message, message
from truepose.sessions.ballbar.attachment import AttachmentEvidence, Contact
from truepose.sessions.ballbar.cell import BallbarCell
from truepose.sessions.ballbar.live import (
    BEYOND_RANGE_MM,
    Gauge,
    LiveSample,
    LiveState,
    WhyNot,
    Window,
    is_usable,
    live_state,
)
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.state import READINGS
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.identity_check import KnownDevice, same_number
from truepose.sessions.errors import NotNowError
from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity


@dataclass(frozen=True, slots=True)
class Papers:
    """Serial number and certificate that a length is kept with."""

    serial: str  # empty where it is not known
    certificate: str
    certificate_expires: str
    hold: bool  # what the cell file says of the ballbar is said of this one


def papers_of(told: str, known: KnownDevice, owner: Artefact, device_serial: str) -> Papers:
    """Return what holds for the ballbar that has just told its serial number.

    Parameters
    ----------
    told : str
        Empty where it tells none.
    known : KnownDevice
        Of the session with its ballbar.
    owner : Artefact
        The ballbar that the cell file describes.
    device_serial : str
        Number that the cell file names for the device, where that is another one than the ballbar's: a
        cable's, a counter's.
    """
    if not told:
        silent = bool(known.serial)  # it did tell one before, so this may be another
        return Papers("", "", "", hold=False) if silent else _of(owner, owner.serial_number)
    # The device's own number comes before the ballbar's: a cable or a counter has a number, and is not what
    # the certificate is of (decision 0020).
    if device_serial and same_number(told, device_serial):
        return _of(owner, owner.serial_number or told)
    # Where the cell file names no number, its certificate is that of the bar that the session met first.
    if same_number(told, owner.serial_number or known.first):
        return _of(owner, told)
    return Papers(told, "", "", hold=False)


def _of(owner: Artefact, serial: str) -> Papers:
    return Papers(serial, owner.certificate, owner.certificate_expires, hold=True)


_NO_ZERO: Final = message("session.bar.no_zero")


@dataclass(frozen=True, slots=True)
class Shown:
    """What the ballbar showed over a window, and what is known of it."""

    window: Window
    time_s: float
    temperature_c: float  # NaN where the ballbar has no thermometer
    papers: Papers
    by_hand: bool


def bars_of(step: BallbarStep, kit: BallbarKit) -> Bars:
    """Return what the ballbar is made up with at a step."""
    return kit.tool_bars if step.artefact == "tool" else kit.base_bars


def length_taken(shown: Shown, now: Situation, step: BallbarStep, kit: BallbarKit) -> LengthTaken:
    """Return the length that is read at this step; raises NotNowError where there is no zero.

    length = calibrator + mean deviation - zero, the zero being the deviation on the calibrator; of standard
    uncertainty sqrt(u_reading^2 + u_zero^2 + u_calibrator^2), and the calibrator's alone on the calibrator.
    """
    bars, deviation_mm = bars_of(step, kit), shown.window.mean_mm
    # On the calibrator the length is the calibrator's by definition, and its uncertainty the certificate's.
    if step.kind is StepKind.INITIALISE:
        zero_mm, number, u_mm = deviation_mm, now.initialisations + 1, bars.calibrator_u_mm
    elif now.zero is not None:
        zero_mm, number = now.zero.zero_mm, now.zero.initialisation
        # the mean of many samples is no better: 2 um at 95 % is what the instrument states of a length
        reading_u_mm = kit.reading_u_mm if shown.papers.hold else kit.uncertified_u_mm
        u_mm = math.hypot(reading_u_mm, kit.zero_u_mm, bars.calibrator_u_mm)
    else:
        raise NotNowError(_NO_ZERO)
    return LengthTaken(
        length_mm=bars.calibrator_mm + deviation_mm - zero_mm,
        deviation_mm=deviation_mm,
        zero_mm=zero_mm,
        standard_uncertainty_mm=u_mm,
        spread_mm=shown.window.spread_mm,
        samples=shown.window.count,
        initialisation=number,
        by_hand=shown.by_hand,
        temperature_c=shown.temperature_c,
        instrument_serial=shown.papers.serial,
        certificate=shown.papers.certificate,
        certificate_expires=shown.papers.certificate_expires,
        time_s=shown.time_s,
    )


_KEPT_FOR_A_WATCHER = 40  # samples: two seconds; who is slower than that misses the oldest
_RECENT_S = 1.0  # a length that was shown longer ago is not what the person sees

_FRESH = 3  # samples that a length stored by hand rests on, all taken after the button was pressed
_MOST_POLLS = 40  # of a ballbar that is slower than the polling

_SETTLES = 10  # polls after which a bar that was taken off, or is held in a hand, has shown it
_SETTLES_LATE = 40  # where polls came so seldom that they show nothing yet
_IN_HAND = 5  # polls that a bar that was just put on is not taken for one in a hand
_PATIENCE_S = 4.0  # wall time, of a ballbar whose driver does not return

_REFUSALS: Final[dict[WhyNot, Message]] = {
    "no_signal": message("session.bar.silent"),
    "out_low": message("session.bar.too_close"),
    "out_high": message("session.bar.too_far"),
    "unstable": message("session.bar.unsteady"),
}


class Readings:
    """Polls the ballbar, keeps its window, and tells everybody who watches."""

    def __init__(
        self, plan: BallbarPlan, kit: BallbarKit, cell: BallbarCell, wall_ms: Callable[[], int]
    ) -> None:
        self._kit = kit
        self._device_serial = cell.ballbar_device_serial
        self._heard = cell.expected.heard
        self._asked_at: str | None = None  # the step at which the ballbar said last who it is
        self._clock: Clock = cell.clock
        self._gauge = Gauge(cell.ballbar, cell.clock)
        self._window = Window(plan.stable_s, plan.stable_mm)
        self._wall_ms = wall_ms
        self._watchers: set[asyncio.Queue[LiveSample | None]] = set()
        self._latest: BallbarReading | None = None
        self._polled = asyncio.Event()
        self._closed = False
        self.contact = Contact()
        self.evidence = AttachmentEvidence(kit.range_mm)
        self.sample: LiveSample | None = None

    @property
    def lost_power(self) -> bool:
        """Whether the ballbar was without supply, and nobody has taken note of it yet."""
        return self._gauge.lost_power

    async def poll(self, now: Situation, *, robot_still: bool) -> LiveSample:
        """Read the ballbar once and tell the watchers."""
        at = now.step.id if now.step else None
        # it may be exchanged behind a bridge or a counter whose link stays up
        # At each step, and at each poll while another one is in question: whoever puts the right one back
        # sees it at once.
        reading = await self._gauge.read(ask=now.ballbar.foreign is not None or at != self._asked_at)
        self._asked_at = self._asked_at if reading is None else at
        if self._gauge.identity is not None:
            self._heard("ballbar", self._gauge.identity)
        sampled_at_ms = self._wall_ms()
        time_s = await self._clock.now_s() if reading is None else reading.time_s
        off_mm = _off_nominal_mm(reading, now, self._kit)
        self.evidence.note(reading, off_mm, asked=now.step is not None and now.step.kind in READINGS)
        if self.evidence.is_stale(time_s):
            reading = None  # what a device only repeats is no length
        self._take(reading, off_mm)
        self.sample = self._sample(reading, now, time_s, robot_still, sampled_at_ms)
        for queue in self._watchers:
            _put(queue, self.sample)
        self._polled.set()
        # Replaced, so that whoever begins to wait now waits for the next poll and not for this one.
        self._polled = asyncio.Event()
        return self.sample

    @property
    def identity(self) -> DeviceIdentity | None:
        """Who the ballbar said it is, when it was asked last; None before that."""
        return self._gauge.identity

    async def ask(self) -> None:
        """Ask the ballbar again who it is; raises DriverError."""
        await self._gauge.ask()

    async def fresh(self) -> None:
        """Return once the window holds nothing but samples taken from now on.

        Who connects the ballbar and presses the button at once must not store what it showed before.
        """
        self.begin_anew()
        for polls in range(_MOST_POLLS):
            # Three polls and a sample: a bar that is slower than the polling may have given one only.
            enough = polls >= _FRESH and self._window.count > 0
            if enough or self._closed or (polls > 0 and not is_usable(self._latest)):
                return
            await self._polled.wait()

    async def settle(self) -> None:
        """Return once it shows whether the ballbar is off: after one sample, or half a second of samples.

        A ballbar that answers and shows nothing is waited for longer, unless a person said where it lies: a
        computer that has other work looks seldom.
        """
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_PATIENCE_S):
                for polls in range(1, _SETTLES_LATE + 1):
                    if self._closed:
                        return
                    await self._polled.wait()
                    if self.sample is not None and self._shows_enough(self.sample, polls):
                        return

    def _shows_enough(self, sample: LiveSample, polls: int) -> bool:
        """Whether so many samples show where the ballbar is, or will not show it."""
        # Neither is going to show anything else soon; who waits is told what speaks against it.
        if self._latest is None or sample.ballbar == "connected":
            return polls >= _SETTLES
        if sample.ballbar == "in_hand":
            return polls >= _IN_HAND
        silent = sample.state == "no_signal"
        return sample.ballbar == "off" or not sample.reason_needed or (silent and polls >= _SETTLES)

    async def watch(self) -> AsyncIterator[LiveSample]:
        """Yield every sample from now on, until the session ends."""
        if self._closed:
            return
        # Bounded: a tablet that fell asleep must not have the service collect samples for it.
        queue: asyncio.Queue[LiveSample | None] = asyncio.Queue(_KEPT_FOR_A_WATCHER)
        self._watchers.add(queue)
        try:
            while (sample := await queue.get()) is not None:
                yield sample
        finally:
            self._watchers.discard(queue)

    async def close(self) -> None:
        """Let the watchers and whoever waits for a sample go, and close the link."""
        self._latest = None
        self._closed = True
        self._polled.set()
        for queue in self._watchers:
            _put(queue, None)
        await self._gauge.close()

    def let_read_again(self, step_id: str) -> None:
        """Let a connection that was taken for this step count as new; another is not what is asked for."""
        shown_mm = None if self.sample is None else self.sample.deviation_mm
        if shown_mm is not None and self.contact.held_for(shown_mm) == step_id:
            self.contact.forget()

    def begin_anew(self) -> None:
        """Forget the samples: what follows belongs to another prompt."""
        self._window.clear()

    def take_note_of_lost_zero(self) -> None:
        """Remember that the zero is known to be lost; what is connected now is not the calibrator."""
        self._gauge.lost_power = False
        self.contact.distrust()

    def is_ready(self, now: Situation, *, robot_still: bool) -> bool:
        """Whether the length may be stored without anybody asking for it."""
        reads = now.step is not None and now.step.kind in READINGS and now.suspicion is None and now.shown
        in_range = self.sample is not None and self.sample.state == "in_range"
        steady = self._window.stable and self.contact.is_new(self._window.mean_mm)
        return reads and in_range and steady and robot_still

    def length(self, now: Situation, now_s: float, *, by_hand: bool) -> LengthTaken:
        """Return the length as it stands; raises NotNowError where there is none that could be kept."""
        reading, sample = self._latest, self.sample
        if now.step is None or now.step.kind not in READINGS:
            raise NotNowError(message("session.refused.no_length_here"))
        # Stored is what the person sees.
        if reading is None or sample is None or abs(now_s - reading.time_s) > _RECENT_S:
            raise NotNowError(_REFUSALS["no_signal"])
        why_not = _why_not(sample.state)
        if why_not is not None:
            raise NotNowError(_REFUSALS[why_not])
        if not self._window.count:
            raise NotNowError(message("session.refused.length_too_soon"))
        temperature_c = math.nan if reading.temperature_c is None else reading.temperature_c
        papers = papers_of(self._gauge.serial, now.ballbar, self._kit.instrument, self._device_serial)
        shown = Shown(self._window, reading.time_s, temperature_c, papers, by_hand)
        return length_taken(shown, now, now.step, self._kit)

    def _take(self, reading: BallbarReading | None, off_mm: float | None) -> None:
        before = self._latest
        self._latest = reading
        if reading is None or not is_usable(reading):
            self._window.clear()
            if reading is not None:  # without a link nobody knows whether it left its cups
                self.contact.note(None)
            return
        beyond = off_mm is not None and abs(off_mm) > self._kit.range_mm + BEYOND_RANGE_MM
        self.contact.note(None if beyond else reading.deviation_mm)
        same = before is not None and reading.sequence is not None and before.sequence == reading.sequence
        if not same:  # a device that is slower than the polling repeats itself
            self._window.add(reading.time_s, reading.deviation_mm)

    def _sample(
        self,
        reading: BallbarReading | None,
        now: Situation,
        time_s: float,
        robot_still: bool,
        sampled_at_ms: int,
    ) -> LiveSample:
        usable = is_usable(reading)
        deviation_mm = None if reading is None else reading.deviation_mm
        off_mm = _off_nominal_mm(reading, now, self._kit)
        reads_zero = now.step is not None and now.step.kind is StepKind.INITIALISE
        # On the calibrator the raw value counts, not the length: the zero that a length counts from is just
        # what is being read.
        state = live_state(
            reading, None if reads_zero else off_mm, self._kit.range_mm, unsteady=self._window.unsteady
        )
        why_not: WhyNot | None = "no_length_here" if CommandName.STORE not in now.acts else _why_not(state)
        return LiveSample(
            time_s=time_s,
            length_mm=self._length_mm(reading, now) if usable else None,
            deviation_mm=deviation_mm if deviation_mm is None or math.isfinite(deviation_mm) else None,
            state=state,
            stable_share=self._window.share if usable else 0.0,
            spread_mm=self._window.spread_mm if usable else None,
            robot_still=robot_still,
            sampled_at_ms=sampled_at_ms,
            ballbar=self.evidence.says(time_s),
            reason_needed=now.exchanged or self.evidence.needs_reason(time_s),
            can_store=why_not is None,
            why_not=why_not,
            let_go=not usable or self.contact.is_new(self._window.mean_mm),
        )

    def _length_mm(self, reading: BallbarReading | None, now: Situation) -> float | None:
        """Return the length; None where it cannot be told."""
        if reading is None or now.step is None or now.zero is None or now.step.kind is StepKind.INITIALISE:
            return None
        return bars_of(now.step, self._kit).calibrator_mm + reading.deviation_mm - now.zero.zero_mm


def _off_nominal_mm(reading: BallbarReading | None, now: Situation, kit: BallbarKit) -> float | None:
    """Return how far the length is off the nominal one with the bars that are on; None where nobody knows."""
    if reading is None or now.zeroed is None or not math.isfinite(reading.deviation_mm):
        return None
    artefact, zero = now.zeroed
    bars = kit.tool_bars if artefact == "tool" else kit.base_bars
    return bars.calibrator_mm + reading.deviation_mm - zero.zero_mm - bars.nominal_mm


def _why_not(state: LiveState) -> WhyNot | None:
    """Return why what is shown is no length that could be kept."""
    return None if state == "in_range" else state


def _put(queue: "asyncio.Queue[LiveSample | None]", sample: LiveSample | None) -> None:
    # The oldest goes: whoever watches wants to know what is, not what was.
    if queue.full():
        queue.get_nowait()
    queue.put_nowait(sample)
