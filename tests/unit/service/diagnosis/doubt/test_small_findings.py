"""Small findings: what takes less than 2 % off the held-out error is no cause that anybody acts upon."""

import math

import pytest

from tests.helpers.diagnosis.answers import make_finding, make_wave
from truepose.diagnosis.confidence import split_by_size
from truepose.domain.diagnosis import Gain

LEAD = make_finding(gain=Gain(0.100, 0.060, (0.03, 0.05)))


def wave(before_mm, after_mm, **changes):
    return make_wave(gain=Gain(before_mm, after_mm, (-0.01, 0.01)), **changes)


@pytest.mark.parametrize(
    ("after_mm", "counted"),
    [(0.0970, True), (0.0979, True), (0.0981, False), (0.1000, False), (0.1100, False)],
)
def test_the_line_is_at_two_hundredths_of_the_held_out_error(after_mm, counted):
    further = wave(0.1, after_mm)

    assert split_by_size((LEAD, further)) == (((LEAD, further), ()) if counted else ((LEAD,), (further,)))


def test_the_leading_finding_counts_however_small():
    lead = wave(0.100, 0.099)

    assert split_by_size((lead,)) == ((lead,), ())
    assert split_by_size((lead, LEAD)) == ((lead, LEAD), ())


@pytest.mark.parametrize("gain", [None, Gain(math.nan, math.nan, (math.nan, math.nan))])
def test_what_no_held_out_reading_judges_is_not_called_small(gain):
    unknown = make_wave(gain=gain)

    assert split_by_size((LEAD, unknown)) == ((LEAD, unknown), ())


def test_bad_readings_are_told_however_little_they_cost():
    """They are weighed out already: what they would have cost says nothing of how bad they are."""
    bad = wave(0.100, 0.0999, effect="outliers", subject="readings", parameters=())

    assert split_by_size((LEAD, bad)) == ((LEAD, bad), ())


def test_nothing_found_is_nothing_small():
    assert split_by_size(()) == ((), ())
