"""A diagnosis against what was planted."""

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding, make_wave
from tests.studies.diagnosis_report.judging import failed, judge
from tests.studies.diagnosis_report.planted.planting import Planted
from truepose.domain.diagnosis import Cause, Confidence, Remaining, Verdict

WAVE = Planted(
    "joint_harmonics", "joint 6", 0.03, {"order": 2.0}, right={Cause("joint_harmonics", "joint 6"): 0.03}
)
GAPS = Planted(
    "backlash",
    "joints",
    0.037,
    right={
        Cause("backlash", "joints"): 0.037,
        Cause("backlash", "joint 4"): 0.037,
        Cause("backlash", "joint 5"): 0.017,
    },
)


def explained(*findings, **changes):
    nothing_left = Remaining(structure=False, depends_on=(), sentence="Noise.")
    values = {"verdict": Verdict.EXPLAINED, "findings": findings, "remaining": nothing_left}
    return make_diagnosis(**(values | changes))


def test_the_planted_effect_is_named_and_scored():
    outcome = judge(explained(make_wave(amplitude=0.034)), (WAVE,))

    assert outcome.detected
    assert outcome.all_named
    assert outcome.wrong == ()
    (named,) = outcome.named
    assert named.scores == (pytest.approx(2.0),)  # 0.004 deg over 0.002 deg
    assert named.order_found is True


def test_a_wave_of_another_order_is_named_without_its_order():
    outcome = judge(explained(make_wave(order=17.0)), (WAVE,))

    (named,) = outcome.named
    assert (named.credit, named.order_found) == (1.0, False)


def test_a_second_wave_of_the_same_joint_is_one_too_many():
    outcome = judge(explained(make_wave(order=17.0), make_wave(order=2.0)), (WAVE,))

    assert outcome.named[0].order_found is True
    assert outcome.wrong == ("joint_harmonics (joint 6)",)


def test_small_findings_are_judged_as_any_other():
    outcome = judge(explained(make_finding(), small=(make_wave(),)), (WAVE,))

    assert outcome.all_named
    assert judge(explained(make_wave(), small=(make_finding(),)), (WAVE,)).wrong == ("backlash (joint 3)",)


def test_gaps_named_joint_by_joint_are_all_right():
    gaps = [make_finding(subject=f"joint {j}", confusable_with=()) for j in (4, 5)]

    outcome = judge(explained(*gaps), (GAPS,))

    assert outcome.wrong == ()
    assert outcome.named[0].scores == (pytest.approx((0.021 - 0.037) / 0.003), pytest.approx(4.0 / 3.0))


def test_a_listed_rival_is_worth_a_half_and_the_name_is_wrong():
    rival = Cause("joint_harmonics", "joint 6")

    outcome = judge(explained(make_finding(confusable_with=(rival,))), (WAVE,))

    assert outcome.named[0].credit == 0.5
    assert outcome.wrong == ("backlash (joint 3)",)
    assert outcome.doubted


def test_a_wrong_name_without_a_rival_is_worth_nothing():
    outcome = judge(explained(make_finding(confusable_with=())), (WAVE,))

    assert outcome.named[0].credit == 0.0
    assert not outcome.doubted


def test_structure_that_is_said_to_remain_is_a_doubt():
    left = Remaining(structure=True, depends_on=(), sentence="Something in joint 4.")

    outcome = judge(explained(make_wave(), verdict=Verdict.PARTLY_EXPLAINED, remaining=left), (WAVE,))

    assert outcome.doubted


def test_consistent_is_no_detection():
    outcome = judge(explained(verdict=Verdict.CONSISTENT), ())

    assert not outcome.detected


def test_a_likely_name_is_seen():
    sure = judge(explained(make_wave()), (WAVE,))
    likely = judge(explained(make_wave(confidence=Confidence.LIKELY)), (WAVE,))

    assert (sure.only_likely, likely.only_likely) == (False, True)


def test_an_amplitude_without_definition_or_uncertainty_is_not_scored():
    undefined = Planted(
        "label_swap", "nest 1, nest 2", 0.03, right={Cause("label_swap", "nest 1, nest 2"): None}
    )
    swap = make_finding(effect="label_swap", subject="nest 1, nest 2")
    certain = make_wave(amplitude_standard_uncertainty=0.0)

    assert judge(explained(swap), (undefined,)).named[0].scores == ()
    assert judge(explained(certain), (WAVE,)).named[0].scores == ()


def test_a_diagnosis_that_failed_detects_and_names_nothing():
    outcome = failed("ZeroDivisionError: division by zero", (WAVE,))

    assert not outcome.detected
    assert not outcome.all_named
    assert outcome.fault


@pytest.mark.parametrize(
    ("where", "over", "wrong"),
    [
        ("joint 6", "time", ()),  # the place is right
        ("link 6", "angle of joint 6", ()),  # what it depends on is
        ("tool", "time", ("unnamed (tool, time, jump)",)),
    ],
)
def test_a_cause_without_a_name_that_describes_what_was_planted_is_not_wrong(where, over, wrong):
    cell = make_finding(
        effect="unnamed", subject=f"{where}, {over}, jump", where=where, over=over, confusable_with=()
    )

    outcome = judge(explained(cell), (WAVE,))

    assert outcome.wrong == wrong
    assert outcome.named[0].credit == 0.0  # described, not named
