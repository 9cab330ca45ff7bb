"""When a length stands still, and whether it belongs to a new connection."""

import math
import random

import pytest

from truepose.sessions.ballbar.attachment import Contact
from truepose.sessions.ballbar.live import Window, live_state
from truepose_drivers.api import BallbarReading

STABLE_S, STABLE_MM = 1.0, 0.002


def fed(values, step_s=0.05):
    window = Window(STABLE_S, STABLE_MM)
    for number, value in enumerate(values):
        window.add(100.0 + number * step_s, value)
    return window


def reading(deviation_mm, signal="good"):
    return BallbarReading(deviation_mm, signal, 0.0001, 1.0)


@pytest.mark.parametrize("seed", range(20))
def test_the_scatter_of_a_good_ballbar_counts_as_standing_still(seed):
    rng = random.Random(seed)

    window = fed([rng.gauss(0.3, 0.00051) for _ in range(21)])

    # twice 0.51 um, known to a tenth from 21 samples, stays below 2 um
    assert window.stable
    assert window.mean_mm == pytest.approx(0.3, abs=4 * 0.00051 / math.sqrt(21))


def test_less_than_the_time_is_not_enough():
    window = fed([0.3] * 20)

    assert not window.stable
    assert window.share == pytest.approx(0.95, abs=1e-3)
    assert not window.unsteady


@pytest.mark.parametrize("drift_mm_s", [0.01, 0.1, 1.0])
def test_a_length_that_drifts_is_unsteady(drift_mm_s):
    window = fed([0.3 + drift_mm_s * 0.05 * number for number in range(60)])

    assert not window.stable
    assert window.unsteady


def test_after_a_jump_it_must_stand_still_anew():
    window = fed([0.3] * 40 + [0.31] * 5)

    assert not window.stable
    assert window.mean_mm == pytest.approx(0.31)


def test_a_clock_that_begins_anew_begins_a_new_window():
    window = fed([0.3] * 40)

    window.add(1.0, 0.3)

    assert window.count == 1


@pytest.mark.parametrize(
    ("shown", "off_mm", "state"),
    [
        (None, None, "no_signal"),
        (reading(math.nan, "none"), None, "no_signal"),
        (reading(math.nan), None, "no_signal"),
        (reading(0.2), 0.2, "in_range"),
        (reading(1.02), 1.025, "in_range"),  # thesis section 3.6 has such a reading
        (reading(0.2), 1.2, "out_high"),
        (reading(0.2), -1.2, "out_low"),
        (reading(1.0, "out_of_range"), None, "out_high"),
        (reading(-1.0, "out_of_range"), None, "out_low"),
    ],
)
def test_the_state_says_what_the_person_should_see(shown, off_mm, state):
    assert live_state(shown, off_mm, 1.0, unsteady=False) == state


def test_a_length_that_moves_is_shown_as_such():
    assert live_state(reading(0.2), 0.2, 1.0, unsteady=True) == "unstable"


def after(*samples):
    contact = Contact()
    contact.note(0.3)
    contact.take(0.3, "leg")
    for sample in samples:
        contact.note(sample)
    return contact


@pytest.mark.parametrize(
    ("samples", "mean_mm", "new"),
    [
        ([0.3, 0.3], 0.3, False),
        ([0.3, None, 0.3], 0.3, True),  # it left its cups
        ([0.3, 0.5, 0.5], 0.5, True),  # too quick to be seen
        ([0.3, 0.5, 0.3], 0.3, False),  # somebody leaned on it
        ([0.3 + 0.001 * k for k in range(30)], 0.329, False),  # warmth
    ],
)
def test_a_connection_is_new_where_the_signal_was_lost_or_the_length_jumped(samples, mean_mm, new):
    assert after(*samples).is_new(mean_mm) is new


def test_where_the_zero_is_lost_only_a_lost_signal_tells_of_a_new_connection():
    contact = after()
    contact.distrust()
    contact.note(0.9)
    assert not contact.is_new(0.9)

    contact.note(None)

    assert contact.is_new(0.9)
