"""What the samples of the ballbar prove: that it is connected, in a hand, off, or nothing at all.

Nothing known counts as attached. The ballbar is off where it was seen to come off: it left its range, or
moved as in a hand, while no length was asked for. Else a person says where it lies and how they know.

- A length within the range is a ballbar that is connected, between two balls or on its calibrator.
- No signal proves nothing: a ballbar without supply between two balls is as silent as one in its box. Nor
  does a count that is repeated, an old reading, a lost link, a device that was restarted, or a reading whose
  value is within the range and whose signal is not.
- A ballbar at its end may hang where it does not read: between two balls that are too far apart for it, not
  for their magnets. So it is off only where it was seen to leave its range; where nothing was seen of it
  before, or a person was asked for a length, nothing is known until it moves as in a hand.
- What was seen, and what a person said, holds until the next length within the range, and until a person is
  next asked to put the ballbar on. It holds through a link that is lost and a ballbar that falls silent.

The same connection must not be stored twice by itself. A ballbar that leaves its cups loses its signal or
runs out of its range, so what follows is a new connection. Where that was too quick to be seen the length
has jumped: between two samples, and to another value than the one that was taken. A slow drift is neither.
"""

import math
from typing import Final

from truepose.messages.message import Message, message
from truepose.sessions.ballbar.live import BEYOND_RANGE_MM, Seen
from truepose_drivers.api import BallbarReading

STILL_ON: Final = message("session.bar.still_on")
NOTHING_KNOWN: Final = message("session.bar.nothing_known")
SEEN_IN_MOTION: Final = message("session.bar.in_motion")

_STALE_S: Final = 1.0  # an older sample says nothing of now
_OFF_S: Final = 0.25  # so long no length must be within the range: a radio link drops samples
_HAND_MM: Final = 0.05  # between two balls that stand still a length moves by some micrometres
_HAND_S: Final = 0.1  # a hand that holds the bar within its range does not rest for longer
_HAND_MOVES: Final = 3  # in a row: a count that hung jumps once, a wild value there and back
_ASLEEP_S: Final = 1.0  # a bar that gave no signal for so long may be elsewhere; a radio link drops less
_PERSISTS_S: Final = 0.4  # so long no hand keeps the bar within its range by chance


class AttachmentEvidence:
    """Follows the samples, and remembers what they proved last."""

    def __init__(self, range_mm: float) -> None:
        self._range_mm = range_mm
        self._linked = False
        self._sample_s: float | None = None  # of the newest sample that was new
        self._sequence: int | None = None
        self._proved: Seen = "unknown"
        self._inside_s: float | None = None  # since when every sample is within the range
        self._outside_s: float | None = None  # since when none is
        self._silent_s: float | None = None  # since when no sample had a signal, however many were missed
        self._may_hang = True  # what is beyond its range now was not seen to come off
        self._value_mm: float | None = None  # where the reading was when it last moved
        self._moved_s = -math.inf  # when that was
        self._moves = 0  # in a row until then
        self._word = False  # a person gave a reason why it is off
        self._arm_moves = False
        self.seen_in_motion = False  # a length within the range persisted since the arm began to move

    def note(self, reading: BallbarReading | None, off_mm: float | None, *, asked: bool = False) -> None:
        """Take the next sample, None without a link; `off_mm` is the length against the nominal one.

        Where the zero is not known it is None, and every good reading may be a length within the range.
        `asked`: a person is asked for a length, and may have put the bar on where it does not read.
        """
        if asked:
            self.expect_length()
        self._linked = reading is not None
        if reading is None:
            self._begin_anew()
            self._may_hang = True
        # A device that repeats its last value, as a hung loop does, has the same count. That is no sample,
        # whatever the value says.
        elif reading.sequence is None or reading.sequence != self._sequence:
            self._follow(reading, off_mm)
        elif self.is_stale(reading.time_s):
            self._may_hang = True

    def expect_length(self) -> None:
        """Forget that the ballbar is off, seen or said: a person is asked to put it on."""
        self._word, self._may_hang = False, True
        # A length within the range goes on proving that it is on; only what spoke for "off" is void.
        if self._proved != "connected":
            self._proved = "unknown"

    def says(self, now_s: float) -> Seen:
        """Return what is known at this moment."""
        return self._proved if self._linked and not self.is_stale(now_s) else "unknown"

    def is_stale(self, now_s: float) -> bool:
        """Whether nothing new has been read for too long, whatever the device repeats."""
        return self._sample_s is None or abs(now_s - self._sample_s) > _STALE_S

    def needs_reason(self, now_s: float) -> bool:
        """Whether a person's word that the ballbar is off takes a reason: nothing is known of it."""
        if self._word or self.says(now_s) != "unknown":
            return False
        # A link that was lost after the bar was seen off changes nothing: it lies where it lay (decision
        # 0018).
        return self._linked or self._proved != "off"

    def believe(self) -> None:
        """Take a person's word, with a reason, until a length within the range is seen."""
        self._word = True

    def against_motion(self, now_s: float) -> Message | None:
        """Return what the samples have against a motion, as a sentence; None where they have nothing."""
        connected = self.says(now_s) == "connected"
        # During a motion one length that persisted is enough, also when it has gone since: the bar may have
        # been torn off by then.
        if self._arm_moves and (connected or self.seen_in_motion):
            return SEEN_IN_MOTION
        if connected:
            return STILL_ON
        return NOTHING_KNOWN if self.needs_reason(now_s) else None

    @property
    def proves_attached(self) -> bool:
        """Whether a length within the range was what was seen last, or persisted while the arm moved."""
        return self.seen_in_motion or self._proved == "connected"

    def watch_motion(self) -> None:
        """Hold every length that persists within the range against the motion that begins."""
        self._arm_moves, self.seen_in_motion = True, False
        # A length from before the motion says nothing of the motion; it has to persist anew.
        self._inside_s = None

    def end_motion(self) -> None:
        """Let the arm stand again."""
        self._arm_moves = False

    def _begin_anew(self) -> None:
        self._inside_s = self._outside_s = self._value_mm = None
        self._moved_s, self._moves = -math.inf, 0

    def _follow(self, reading: BallbarReading, off_mm: float | None) -> None:
        now_s = reading.time_s
        if self._sample_s is not None and not 0.0 <= now_s - self._sample_s <= _STALE_S:
            self._begin_anew()  # a gap, or a clock that began anew
        self._sample_s, self._sequence = now_s, reading.sequence
        # Movement first: whether a length within the range is in a hand depends on it.
        self._note_movement(reading)
        if self._is_within(reading, off_mm):
            self._follow_inside(now_s)
            return
        self._inside_s = None
        self._outside_s = now_s if self._outside_s is None else self._outside_s
        if _is_silent(reading):
            self._follow_silence(now_s)
        else:
            self._follow_beyond(now_s, contradicts_itself=self._reads_within(reading, off_mm))

    def _follow_silence(self, now_s: float) -> None:
        if self._silent_s is None or now_s < self._silent_s:
            self._silent_s = now_s
        # What was seen to come off stays off through silence; everything else becomes unknown.
        if self._proved != "off" and self._is_outside(now_s):
            self._proved = "unknown"

    def _follow_inside(self, now_s: float) -> None:
        self._outside_s = self._silent_s = None
        # A length within the range outranks what a person said: signals outrank words.
        self._word = self._may_hang = False
        self._inside_s = now_s if self._inside_s is None else self._inside_s
        self._proved = "in_hand" if self._is_in_hand(now_s) else "connected"
        self.seen_in_motion |= self._arm_moves and now_s - self._inside_s >= _PERSISTS_S

    def _follow_beyond(self, now_s: float, *, contradicts_itself: bool) -> None:
        woke = self._silent_s is not None and now_s - self._silent_s >= _ASLEEP_S
        self._may_hang = (self._may_hang or woke or contradicts_itself) and not self._is_in_hand(now_s)
        self._silent_s = None
        if self._is_outside(now_s):
            self._proved = "unknown" if self._may_hang else "off"

    def _is_outside(self, now_s: float) -> bool:
        return self._outside_s is not None and now_s - self._outside_s >= _OFF_S

    def _is_in_hand(self, now_s: float) -> bool:
        return self._moves >= _HAND_MOVES and now_s - self._moved_s < _HAND_S

    def _reads_within(self, reading: BallbarReading, off_mm: float | None) -> bool:
        """Whether the value is one within the range, whatever the signal says."""
        return abs(reading.deviation_mm if off_mm is None else off_mm) < self._range_mm - BEYOND_RANGE_MM

    def _is_within(self, reading: BallbarReading, off_mm: float | None) -> bool:
        if reading.signal != "good" or not math.isfinite(reading.deviation_mm):
            return False
        return off_mm is None or abs(off_mm) <= self._range_mm + BEYOND_RANGE_MM

    def _note_movement(self, reading: BallbarReading) -> None:
        if _is_silent(reading):
            self._value_mm, self._moved_s, self._moves = None, -math.inf, 0
        elif self._value_mm is None:
            self._value_mm = reading.deviation_mm
        elif abs(reading.deviation_mm - self._value_mm) > _HAND_MM:
            # A movement each now and then is a table that was bumped, and no hand.
            in_a_row = reading.time_s - self._moved_s < _OFF_S
            self._moves = self._moves + 1 if in_a_row else 1
            self._value_mm, self._moved_s = reading.deviation_mm, reading.time_s


def _is_silent(reading: BallbarReading) -> bool:
    return reading.signal == "none" or not math.isfinite(reading.deviation_mm)


# Twenty times the scatter of a reading and three times what the zero walks by; two legs of a pose agree as
# well as that by chance once in fifty times, and the button is there.
JUMP_MM: Final = 0.01


class Contact:
    """Follows the raw deviation of the ballbar [mm]."""

    def __init__(self) -> None:
        self._taken_mm: float | None = None
        self._taken_for = ""
        self._lost = True
        self._jumped = False
        self._before_mm: float | None = None

    def note(self, deviation_mm: float | None) -> None:
        """Take the next sample; None without a usable signal."""
        if deviation_mm is None:
            self._lost = True
        elif self._before_mm is not None and abs(deviation_mm - self._before_mm) > JUMP_MM:
            self._jumped = True
        self._before_mm = deviation_mm

    def take(self, deviation_mm: float, step_id: str) -> None:
        """Remember that a length was taken here for a step; "" where it is not what was asked for."""
        self._taken_mm = deviation_mm
        self._taken_for = step_id
        self._lost = self._jumped = False

    def distrust(self) -> None:
        """Let nothing but a lost signal count as new: values are counted from elsewhere now."""
        self._taken_mm = None
        self._lost = self._jumped = False

    def forget(self) -> None:
        """Let the present connection be read again: a person wants that."""
        self._lost = True

    def held_for(self, deviation_mm: float) -> str | None:
        """Return the step for which what is connected was taken already; None where it is new."""
        return None if self.is_new(deviation_mm) else self._taken_for

    def is_new(self, deviation_mm: float) -> bool:
        """Whether a length that stands at this deviation belongs to another connection."""
        if self._lost or self._taken_mm is None:
            return self._lost
        # Both: a jump that came back to the value that was taken is the same connection, and a slow drift
        # away from it too.
        return self._jumped and abs(deviation_mm - self._taken_mm) > JUMP_MM
