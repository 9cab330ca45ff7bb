"""One cause of each kind, hidden in a simulated campaign: found, named, and its size told.

How often each is found, at which sizes and beside what else: `tests/thorough/system/diagnosis`.
"""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.found_causes import assert_found, case
from tests.studies.diagnosis_report.planted.cases import FOR_INFORMATION, REALISTIC
from tests.studies.diagnosis_report.study import trial_of
from tests.studies.diagnosis_report.trials import Trial
from truepose.domain.diagnosis import Verdict

# Two at once name twice as many causes for little more than one costs.
TOGETHER = (
    ("wave of joint 6", "gain of joint 5"),
    ("backlash", "base drifts"),
    ("joint 6 moves", "base jumps"),
    ("links grow", "readings off"),
    ("tracker drifts", "payload"),
)
ALONE = ("axes 2 and 3", "gears 50 %", "one nest")


def test_every_effect_of_the_study_is_here_but_one_that_may_be_doubted():
    named = {case(part).planted(0, 100).effect for part in (*sum(TOGETHER, ()), *ALONE)}

    assert {one.planted(0, 100).effect for one in REALISTIC} - named == {"tool_reseating"}


@pytest.mark.parametrize("pair", TOGETHER, ids=" and ".join)
def test_two_effects_at_once_are_both_found(pair, diagnosed):
    hidden = tuple(case(part) for part in pair)

    assert_found(*diagnosed(trial_of(hidden, 200, seed=51)))


@pytest.mark.parametrize("part", ALONE)
def test_an_effect_is_found_in_a_hundred_readings(part, diagnosed):
    diagnosis, outcome = diagnosed(trial_of((case(part),), 100, seed=21))

    assert_found(diagnosis, outcome)
    assert diagnosis.after.rms_mm < diagnosis.before.rms_mm


def test_swapped_labels_are_found(diagnosed):
    diagnosis, outcome = diagnosed(trial_of(FOR_INFORMATION, 100, seed=21))

    assert outcome.all_named, diagnosis.message
    assert outcome.wrong == ()


def test_a_cause_left_out_of_the_library_gets_no_undoubted_name(diagnosed):
    trial = trial_of((case("joint 6 moves"),), 100, seed=71)

    diagnosis, outcome = diagnosed(replace(trial, without=("joint_coupling",)))

    assert outcome.detected
    assert not outcome.wrong or outcome.doubted, diagnosis.message


@pytest.mark.parametrize("heavy_tails", [False, True], ids=["normal noise", "heavy tails"])
def test_a_robot_without_further_effects_is_consistent(heavy_tails, diagnosed):
    diagnosis, _ = diagnosed(Trial("nothing", (), 100, 61, heavy_tails=heavy_tails))

    assert (diagnosis.verdict, diagnosis.findings) == (Verdict.CONSISTENT, ()), diagnosis.message
    assert not diagnosis.remaining.structure
    assert diagnosis.after == diagnosis.before
