"""What is counted of wrong connections."""

from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.ballbar.coded_stops import coded_stop
from tests.studies.ballbar_report.connection_section import connection_section
from tests.studies.ballbar_report.connections import Course, SlipCounts, count_slips, silences
from truepose.reports.table_report import Verdict


@pytest.fixture
def stop():
    return coded_stop(np.random.default_rng(4))


def row(section, part):
    (found,) = (one for one in section.rows if part in one.figure)
    return found


def test_a_stop_without_slips_raises_no_doubt(stop):
    course = Course(stop, {})

    assert course.silent
    assert course.named_by_pose()  # nothing to name, nothing named


def test_exchanged_legs_are_named_by_the_pose_and_the_first_of_them_at_once(stop):
    first, second = stop.legs[1], stop.legs[4]

    course = Course(stop, {first: second, second: first})

    assert not course.silent
    assert course.named_at_once(first)
    assert course.named_by_pose()


def test_a_pair_read_again_is_named_as_that(stop):
    first, second = stop.legs[:2]

    course = Course(stop, {second: first})

    assert course.named_at_once(second, kind="same_pair")
    assert not course.named_at_once(second, kind="exchanged")


def test_the_readings_speak_for_the_true_pairs_as_loudly_as_the_codes_differ(stop):
    first, second = stop.legs[1], stop.legs[4]

    odds = Course(stop, {first: second, second: first}).log_odds_of_slip()

    # two legs off by 0.28 mm or more where 0.06 mm were foreseen: half the squares of 4.7 each
    assert odds > 15.0
    assert Course(stop, {}).log_odds_of_slip() == pytest.approx(0.0)


def test_an_exchange_of_legs_that_aim_at_one_length_is_hardly_ever_named():
    rng = np.random.default_rng(6)
    named = 0
    for _ in range(5):
        stop = coded_stop(rng, offsets_mm=np.zeros(6))
        named += Course(stop, {stop.legs[0]: stop.legs[3], stop.legs[3]: stop.legs[0]}).named_by_pose()

    # six lengths that differ by what is foreseen of them fit another pose: coded ones are named in every case
    assert named <= 2


def test_counts_of_two_runs_add_up():
    together = count_slips(2, 1) + count_slips(3, 2)

    assert together.stops == 5
    assert together.exchanged_named <= 5
    assert {type(count) for count in asdict(together).values()} == {int}  # JSON knows no other whole numbers


def test_slips_that_nobody_asked_about_are_weighed_by_what_the_readings_say():
    loud, faint = (
        SimpleNamespace(silent=True, log_odds_of_slip=lambda odds=odds: odds) for odds in (5.0, 1.0)
    )
    heard = SimpleNamespace(silent=False)

    counts = silences([loud, faint, heard])

    # a slip in a hundred connections: log 100 = 4.6 lies between the two
    assert asdict(counts) == asdict(SlipCounts(silent=2, silent_likelier=2, silent_against_evidence=1))
    assert {type(count) for count in asdict(counts).values()} == {int}


@pytest.mark.parametrize(("named", "verdict"), [(198, Verdict.PASSED), (197, Verdict.FAILED)])
def test_a_share_must_reach_its_target(named, verdict):
    section = connection_section(SlipCounts(stops=200, exchanged_named=named))

    assert row(section, "both named").verdict is verdict


def test_stops_without_another_pair_in_range_are_no_failures_to_name_one():
    section = connection_section(SlipCounts(stops=100, single_named=76, single_nowhere=20))

    assert row(section, "single").measured == "95.00 % (76 of 80)"
    assert row(section, "single").verdict is Verdict.PASSED


def test_one_slip_stored_against_the_evidence_fails_the_figure():
    section = connection_section(
        SlipCounts(stops=100, silent=1, silent_likelier=1, silent_against_evidence=1)
    )

    assert row(section, "against the evidence").verdict is Verdict.FAILED
