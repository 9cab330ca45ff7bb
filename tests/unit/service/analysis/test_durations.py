"""How long a job takes is learnt from those before it; how far it is never stands still."""

import pytest

from truepose.analysis.job_queue.scheduling import expected_s, outlook
from truepose.storage.records import JobKind, JobTaken

KIND = JobKind.IDENTIFICATION


def test_a_computer_that_took_thrice_as_long_is_expected_to_do_so_again():
    earlier = [JobTaken(100, 3 * expected_s(KIND, 100, []))]

    assert expected_s(KIND, 1000, earlier) == pytest.approx(3 * expected_s(KIND, 1000, []))


def test_one_job_on_a_busy_day_changes_nothing():
    usual = [JobTaken(100, 4.0)] * 4

    assert expected_s(KIND, 100, [*usual, JobTaken(100, 400.0)]) == expected_s(KIND, 100, usual)


def test_before_a_worker_tells_anything_time_alone_moves_on():
    early, later = outlook(20.0, 1.0, 0.0, 0.0), outlook(20.0, 15.0, 0.0, 0.0)

    assert (early.remaining_s, later.remaining_s) == (19.0, 5.0)
    assert (early.fraction, later.fraction) == (0.05, 0.75)


def test_the_more_is_done_the_more_its_own_word_counts():
    assert outlook(100.0, 5.0, 0.1, 5.0).remaining_s == pytest.approx(0.9 * 100 + 0.1 * 50 - 5)
    assert outlook(100.0, 45.0, 0.9, 45.0).remaining_s == pytest.approx(0.1 * 100 + 0.9 * 50 - 45)


@pytest.mark.parametrize("elapsed_s", [19.5, 40.0, 4000.0])
def test_a_late_job_is_never_said_to_be_done(elapsed_s):
    late = outlook(20.0, elapsed_s, 0.0, 0.0)

    assert 0.7 < late.fraction < 1.0
    assert late.remaining_s > 0
