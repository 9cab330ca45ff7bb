"""What the samples of the ballbar prove."""

import math

import pytest

from truepose.sessions.ballbar.attachment import NOTHING_KNOWN, SEEN_IN_MOTION, STILL_ON, AttachmentEvidence
from truepose_drivers.api import BallbarReading

STEP_S = 0.05


class Stream:
    """Samples at 20 Hz into the evidence."""

    def __init__(self):
        self.evidence = AttachmentEvidence(range_mm=1.0)
        self.now_s = 100.0
        self.number = 0

    def see(self, *deviations_mm, signal="good", off_mm=..., sequence=..., asked=False):
        """Take samples; NaN is a sample without signal."""
        for shown_mm in deviations_mm:
            self.now_s += STEP_S
            self.number += 1
            what = "none" if math.isnan(shown_mm) else signal
            count = self.number if sequence is ... else sequence
            reading = BallbarReading(shown_mm, what, 0.0001, self.now_s, None, count)
            self.evidence.note(reading, shown_mm if off_mm is ... else off_mm, asked=asked)
        return self

    def lose_link(self, samples=10):
        self.now_s += samples * STEP_S
        self.evidence.note(None, None)
        return self

    @property
    def says(self):
        return self.evidence.says(self.now_s)

    @property
    def needs_reason(self):
        return self.evidence.needs_reason(self.now_s)

    @property
    def against(self):
        return self.evidence.against_motion(self.now_s)


STILL = [0.3, 0.3002] * 5
NONE = [math.nan] * 8
OUT = [1.3] * 8  # beyond the range
SWAYS = [0.7 * math.sin(0.9 * n) for n in range(20)]


def test_a_length_that_stands_still_within_the_range_is_a_ballbar_that_is_connected():
    stream = Stream().see(*STILL)

    assert stream.says == "connected"
    assert stream.against == STILL_ON


def test_a_ballbar_that_falls_silent_is_not_known_to_be_off():
    stream = Stream().see(*STILL, *NONE[:3])
    assert stream.says == "connected"  # a radio link drops samples

    stream.see(*NONE)  # or was switched off between two balls

    assert stream.says == "unknown"
    assert stream.against == NOTHING_KNOWN
    assert stream.needs_reason


def test_a_ballbar_that_was_never_seen_and_is_silent_is_not_known_to_be_off():
    assert Stream().see(*NONE * 4).against == NOTHING_KNOWN


def test_one_that_falls_silent_after_it_was_seen_to_come_off_is_off():
    stream = Stream().see(*STILL, *OUT, *NONE * 5)

    assert stream.says == "off"
    assert stream.against is None


@pytest.mark.parametrize("lost", [False, True], ids=["silent", "without a link"])
@pytest.mark.parametrize("known", ["seen", "said"])
def test_neither_sight_nor_word_outlives_the_next_length_that_is_asked_for(known, lost):
    stream = Stream().see(*STILL, *(OUT if known == "seen" else ()), *NONE)
    if known == "said":
        stream.evidence.believe()
    if lost:
        stream.lose_link()
    assert not stream.needs_reason

    stream.evidence.expect_length()

    assert stream.needs_reason
    assert stream.against == NOTHING_KNOWN


def test_what_is_beyond_its_range_once_its_link_is_back_may_have_been_put_on_meanwhile():
    assert Stream().see(*STILL).lose_link().see(*OUT).says == "unknown"
    assert Stream().see(*STILL).see(*[0.3] * 30, sequence=7).see(*OUT).says == "unknown"


def test_a_single_jump_is_no_hand():
    stream = Stream().see(*STILL).see(0.6)
    assert stream.says == "connected"
    assert stream.see(0.3, 0.3002).says == "connected"  # a wild value, there and back


@pytest.mark.parametrize("off_mm", [1.06, -1.2, 30.0])
def test_a_ballbar_that_has_run_to_its_end_is_off_whatever_its_own_zero_is(off_mm):
    by_value = Stream().see(*STILL).see(*[40.0 + off_mm] * 8, off_mm=off_mm)
    by_signal = Stream().see(*STILL).see(*[1.01] * 8, signal="out_of_range")

    assert (by_value.says, by_signal.says) == ("off", "off")


def test_a_reading_that_contradicts_itself_proves_nothing():
    assert Stream().see(*STILL).see(*[0.3] * 8, signal="out_of_range").says == "unknown"


def test_a_ballbar_that_runs_to_its_end_while_a_length_is_asked_for_may_hang_where_it_does_not_read():
    stream = Stream().see(*STILL, asked=True).see(*OUT, asked=True).see(*OUT * 5)

    assert stream.says == "unknown"
    assert stream.against == NOTHING_KNOWN


def test_a_ballbar_that_wakes_at_its_end_may_have_been_put_on_where_it_does_not_read():
    slept, dropped = Stream().see(*STILL, *OUT, *NONE * 3, *OUT), Stream().see(*STILL, *OUT, *NONE, *OUT)

    assert (slept.says, dropped.says) == ("unknown", "off")  # a radio link drops samples


def test_a_ballbar_that_was_at_its_end_before_anybody_looked_may_hang():
    assert Stream().see(*OUT).says == "unknown"


@pytest.mark.parametrize("after", [SWAYS, [*STILL, *OUT], [1.2, 1.4, 1.3, 1.2]], ids=len)
def test_one_that_may_hang_is_off_once_it_is_moved(after):
    stream = Stream().see(*OUT, asked=True).see(*after)

    assert stream.says in {"off", "in_hand"}
    assert stream.against is None


def test_where_the_zero_is_not_known_every_good_reading_may_be_a_length_within_the_range():
    assert Stream().see(*[57.3] * 8, off_mm=None).says == "connected"


def test_a_reading_that_moves_through_the_range_is_a_ballbar_in_a_hand():
    stream = Stream().see(*SWAYS)

    assert stream.says == "in_hand"
    assert stream.against is None


def test_a_ballbar_that_comes_to_rest_after_a_hand_is_connected():
    assert Stream().see(*SWAYS, 0.3, 0.3002, 0.3, 0.3002).says == "connected"


def test_one_that_is_put_on_is_connected_from_its_first_sample():
    assert Stream().see(*NONE, 0.3).says == "connected"


def test_nothing_is_known_before_anything_was_seen():
    stream = Stream()

    assert stream.says == "unknown"
    assert stream.against == NOTHING_KNOWN


def test_a_link_that_is_lost_proves_nothing_unless_the_ballbar_was_seen_off_before():
    after_length, after_off = Stream().see(*STILL).lose_link(), Stream().see(*STILL, *OUT).lose_link()
    after_hand = Stream().see(*SWAYS).lose_link()

    assert (after_length.says, after_off.says) == ("unknown", "unknown")
    assert after_length.needs_reason and after_hand.needs_reason
    assert not after_off.needs_reason


def test_a_word_with_a_reason_counts_until_a_length_is_seen():
    stream = Stream().see(*STILL).lose_link()

    stream.evidence.believe()

    assert stream.against is None
    stream.see(0.3).lose_link()
    assert stream.against == NOTHING_KNOWN


@pytest.mark.parametrize("last", [0.3, math.nan])
def test_a_count_that_stands_still_is_no_evidence_however_often_it_is_repeated(last):
    stream = Stream().see(*STILL, *NONE).see(*[last] * 40, sequence=7)

    assert stream.says == "unknown"
    assert stream.needs_reason  # it answers and says nothing new: that is no link that was lost


def test_what_nobody_asked_for_in_a_while_is_no_evidence():
    stream = Stream().see(*NONE)
    stream.now_s += 1.5

    assert stream.says == "unknown"
    assert stream.needs_reason


def test_a_clock_that_began_anew_does_not_keep_what_was_seen():
    stream = Stream().see(*NONE)
    stream.now_s = 3.0

    assert stream.says == "unknown"
    assert stream.see(*STILL).says == "connected"


def test_a_length_that_persists_while_the_arm_moves_is_held_against_the_motion_also_when_it_is_gone():
    stream = Stream().see(*STILL, *OUT)
    stream.evidence.watch_motion()
    assert stream.see(*STILL, *OUT).says == "off"

    assert stream.against == SEEN_IN_MOTION
    stream.evidence.end_motion()
    assert stream.against is None
    stream.evidence.watch_motion()
    assert stream.against is None


def test_a_passage_through_the_range_while_the_arm_moves_is_not():
    stream = Stream().see(*STILL, *OUT)
    stream.evidence.watch_motion()

    stream.see(*SWAYS[:4], *OUT)

    assert stream.against is None
