"""The answer as a whole: verdict, findings, what is withdrawn, and the model that it hands over."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START, telling_campaign
from tests.helpers.diagnosis.selections import (
    PRESENT,
    left_of,
    make_selected,
    make_start,
    planted,
    with_unseen,
)
from tests.helpers.identification.synthetic import NOISE_MM, shifted
from truepose.diagnosis.answer import _verdict, unanswerable
from truepose.diagnosis.confidence import _useless
from truepose.diagnosis.diagnose import diagnose
from truepose.diagnosis.evidence.held_out_errors import Improvement, gain_of
from truepose.domain.diagnosis import Confidence, HeldOutErrors, Verdict
from truepose.identification.model.prediction import predict
from truepose.messages.catalogue import english

GAIN_4 = {"joint_gain": {"gain_4": 1e-3}}
NUISANCE = ("frame_", "fixed_", "certified_")


@pytest.fixture(scope="module")
def campaign():
    return with_unseen(GAIN_4)


@pytest.fixture(scope="module")
def explained_step_by_step(campaign):
    """A diagnosis, and what was told of its progress."""
    told = []
    return diagnose(campaign, PRESENT, lambda share, doing: told.append((share, doing))), told


@pytest.fixture(scope="module")
def explained(explained_step_by_step):
    return explained_step_by_step[0]


@pytest.fixture(scope="module")
def crossed(campaign):
    """A diagnosis without validation readings."""
    return diagnose(replace(campaign, validation=None), PRESENT)


@pytest.fixture(scope="module")
def consistent():
    return diagnose(with_unseen({}), PRESENT)


@pytest.fixture(scope="module")
def nameless(campaign):
    """A diagnosis that has no name for what is wrong."""
    return diagnose(campaign, START, without=("joint_gain", "joint_harmonics"))


def test_where_nothing_is_planted_the_model_is_consistent(consistent):
    assert consistent.verdict is Verdict.CONSISTENT
    assert (consistent.findings, consistent.withdrawn, consistent.remaining.depends_on) == ((), (), ())
    assert not consistent.remaining.structure
    assert np.array_equal(consistent.errors.before_mm, consistent.errors.after_mm)


def test_a_planted_cause_is_named_measured_and_certain(explained):
    (finding,) = explained.findings

    assert explained.verdict is Verdict.EXPLAINED
    assert (finding.effect, finding.subject, finding.unit) == ("joint_gain", "joint 4", "1")
    assert finding.amplitude == pytest.approx(1e-3, abs=4 * finding.amplitude_standard_uncertainty)
    assert finding.confidence is Confidence.CERTAIN
    assert finding.confusable_with == ()
    assert finding.gain.interval_95_mm[0] > 0.0
    assert finding.share == 1.0


def test_a_finding_says_where_it_acts_over_what_and_what_it_is_worth(explained, campaign):
    (finding,) = explained.findings
    turn = 1e-3 * campaign.calibration.stops.joints_rad[:, 3]

    assert (finding.where, finding.over, finding.shape) == ("joint 4", "angle of joint 4", "line")
    assert 0.0 < finding.worth.mean_mm < finding.worth.max_mm
    assert finding.worth.max_mm < 400.0 * np.abs(turn).max()  # no reading is farther from the axis than that


def test_a_curve_holds_the_validation_readings_where_there_are_some(explained, crossed):
    assert len(explained.findings[0].curve.unseen.x) > 30
    assert crossed.findings[0].curve.unseen is None
    assert (explained.remaining.described, explained.remaining.described_gain) == ((), None)


def test_what_was_tried_and_not_found_says_how_large_it_could_still_be(explained):
    limits = {(one.effect, one.subject): one.upper_limit_mm for one in explained.ruled_out}
    unseen = [one.upper_limit_mm for one in explained.ruled_out if not one.visible]

    # A wave of the joint farthest out is held by the readings; the base may turn with its own frame.
    assert 0.0 < limits["backlash", "joint 3"] < 0.05
    assert set(unseen) == {None}


def test_what_no_material_does_is_likely_at_most_and_says_so():
    found = diagnose(planted({"thermal_growth": {"growth": -1e-4}}, n=60), PRESENT)

    (finding,) = [one for one in found.findings if one.over == "temperature"][:1]
    assert finding.effect == "thermal_growth"
    assert finding.confidence is Confidence.LIKELY
    assert english(finding.sentence).endswith(
        ". This value is not plausible (no robot material expands or shrinks that much): "
        "there must be a different cause."
    )


def test_the_first_line_and_the_statistics_tell_the_same_numbers(explained):
    assert explained.held_out == "validation"
    assert explained.before.n == explained.after.n == 40
    assert f"{explained.before.mean_mm:#.3g}" in english(explained.message)
    assert f"{explained.after.mean_mm:#.3g}" in english(explained.message)
    # noise of three components, 1.6 of one on average; parameters add a tenth to a sixth
    assert explained.after.mean_mm < 1.9 * NOISE_MM < explained.before.mean_mm


def test_the_nominal_robot_is_judged_on_the_readings_that_judge_the_model(explained, crossed):
    for found in (explained, crossed):
        assert found.nominal.n == found.before.n
        assert found.nominal.mean_mm > 1.5 * found.before.mean_mm


def test_without_validation_the_answer_says_that_it_was_cross_validated(crossed):
    assert crossed.held_out == "cross_validation"
    assert crossed.before.n == 80
    assert crossed.verdict is Verdict.EXPLAINED


def test_the_extended_model_predicts_unseen_points_as_the_answer_says(explained, campaign):
    points = campaign.validation

    predicted, _ = predict(explained.model, points.stops, points.nest)

    errors = points.position_mm - predicted
    # nests rest in their certificates again: 2 um that the fit of the diagnosis had free
    assert errors == pytest.approx(explained.errors.after_mm, abs=4 * 0.002)
    assert np.linalg.norm(errors, axis=1).mean() == pytest.approx(explained.after.mean_mm, rel=0.1)


def test_a_model_holds_what_was_found_and_nothing_that_only_the_diagnosis_needed(explained, consistent):
    names = [parameter.name for parameter in explained.model.parameters]

    assert set(explained.findings[0].parameters) <= set(names)
    assert not [name for name in names if name.startswith(NUISANCE)]
    assert explained.model.effects == (*PRESENT, "joint_gain")
    assert consistent.model.effects == PRESENT


def test_a_model_of_a_moving_instrument_keeps_the_fixed_nests_that_hold_its_frame():
    rate_mm_per_s = 0.4 / 3600.0
    still = planted({})
    points, looks = still.calibration, still.reference
    moving = [
        replace(rows, position_mm=rows.position_mm + np.outer(rate_mm_per_s * time_s, [1.0, 0.0, 0.0]))
        for rows, time_s in ((points, points.stops.time_s), (looks, looks.time_s))
    ]

    found = diagnose(replace(still, calibration=moving[0], reference=moving[1]), PRESENT)

    names = [parameter.name for parameter in found.model.parameters]
    assert [finding.effect for finding in found.findings] == ["instrument_drift"]
    assert [name for name in names if name.startswith(("frame_", "fixed_"))]
    assert not [name for name in names if name.startswith("certified_")]


@pytest.mark.parametrize("answer", ["explained", "crossed", "nameless", "consistent"])
def test_a_model_says_of_unseen_points_what_they_show(request, answer, campaign):
    model = request.getfixturevalue(answer).model
    unseen = (with_unseen({}) if answer == "consistent" else campaign).validation

    predicted, stated = predict(model, unseen.stops, unseen.nest)

    ratio = (unseen.position_mm - predicted) / np.hypot(stated, NOISE_MM)[:, None]
    # 120 components know their scatter to 7 %
    assert np.sqrt(np.mean(ratio**2)) == pytest.approx(1.0, abs=0.2)


def test_a_cause_left_out_of_the_library_is_not_named_and_something_is_left(nameless):
    found = nameless

    assert {"joint_gain", "joint_harmonics"}.isdisjoint(finding.effect for finding in found.findings)
    assert found.verdict in {Verdict.UNEXPLAINED, Verdict.PARTLY_EXPLAINED}
    assert any("joint 4" in one.variable for one in found.remaining.depends_on)
    assert all(finding.confidence is Confidence.LIKELY for finding in found.findings)


def test_a_description_that_unseen_points_contradict_is_in_no_model(campaign, nameless):
    elsewhere = replace(campaign, validation=with_unseen({}).validation)

    found = diagnose(elsewhere, START, without=("joint_gain", "joint_harmonics"))

    assert nameless.remaining.described
    assert (found.remaining.described, found.remaining.described_gain) == ((), None)
    assert found.remaining.structure
    assert "An empirical description of the residuals" in english(found.remaining.sentence)
    assert "An empirical description of the residuals" not in english(nameless.remaining.sentence)
    assert found.model.effects == START


def test_every_cause_is_found_ruled_out_or_not_visible(explained):
    mentioned = {one.effect for one in (*explained.findings, *explained.ruled_out)}

    assert {"backlash", "base_drift", "payload", "ballbar_zero", "fixture_shift"} <= mentioned
    assert all(one.p_value is None for one in explained.ruled_out if not one.visible)
    assert all(one.p_value is not None for one in explained.ruled_out if one.visible)
    assert ("joint_gain", "joint 4") not in {(one.effect, one.subject) for one in explained.ruled_out}


def test_progress_never_goes_back(explained_step_by_step):
    _, told = explained_step_by_step

    shares = [share for share, _ in told]
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < shares[-1] <= 1.0
    assert all(doing for _, doing in told)


@pytest.mark.parametrize(
    ("found", "structure", "verdict"),
    [
        (False, False, Verdict.CONSISTENT),
        (True, False, Verdict.EXPLAINED),
        (True, True, Verdict.PARTLY_EXPLAINED),
        (False, True, Verdict.UNEXPLAINED),
    ],
)
def test_the_verdict_says_whether_causes_were_found_and_whether_something_is_left(found, structure, verdict):
    assert _verdict(found, structure) is verdict


@pytest.fixture(scope="module")
def picked():
    """Two picks with their groups, and what they leave."""
    start = make_start({"joint_gain": {"gain_4": 1e-3, "gain_5": 1e-3}})
    selected = make_selected(start, [("joint_gain", "joint 4"), ("joint_gain", "joint 5")])
    groups = tuple((pick.subject, (pick,)) for pick in selected.picks)
    return selected, groups, left_of(start, selected)


def judged(before_mm, after_mm, *without_mm, n=60, seen_in=(5, 5)):
    """Held-out errors of these sizes, the same noise in all of them."""
    noise = np.random.default_rng(1).standard_normal((n, 3))
    errors = HeldOutErrors(np.arange(n), np.zeros((n, 3)), before_mm * noise, after_mm * noise)
    site = np.arange(n)
    gains = tuple(gain_of(size * noise, after_mm * noise, site) for size in without_mm)
    return Improvement(errors, gains, seen_in, site, 0.01, "cross_validation")


def test_findings_that_help_stay(picked):
    assert _useless(*picked[:2], judged(0.10, 0.02, 0.06, 0.07), picked[2]) == ()


def test_a_finding_that_makes_unseen_points_worse_is_withdrawn_alone(picked):
    assert _useless(*picked[:2], judged(0.10, 0.02, 0.06, 0.019), picked[2]) == (1,)


def test_findings_that_spoil_what_is_left_out_together_are_all_withdrawn(picked):
    assert _useless(*picked[:2], judged(0.02, 0.021, 0.06, 0.07), picked[2]) == (0, 1)


def test_what_fewer_readings_do_not_show_is_not_refuted(picked):
    """The folds chose nothing, or as much that helps as that does not."""
    assert _useless(*picked[:2], judged(0.02, 0.02, 0.06, 0.07), picked[2]) == ()


@pytest.mark.parametrize(("after_mm", "useless"), [(0.02, (1,)), (0.0195, ())])
def test_what_hardly_a_fold_chooses_goes_where_the_choice_does_not_help(picked, after_mm, useless):
    """Single readings made it: without them nobody would have found it."""
    assert _useless(*picked[:2], judged(0.02, after_mm, 0.06, 0.07, seen_in=(2, 1)), picked[2]) == useless


def test_beside_something_large_that_nothing_explains_a_small_help_is_not_claimed(picked):
    selected, groups, left = picked
    small = judged(0.100, 0.095, 0.097, 0.098)

    assert _useless(selected, groups, small, left) == ()
    assert _useless(selected, groups, small, replace(left, more_than_stated=True)) == (0, 1)


@pytest.fixture(scope="module")
def contradicted(campaign):
    """A diagnosis whose validation readings come from a robot without the gain: it cannot help there."""
    return diagnose(replace(campaign, validation=with_unseen({}).validation), PRESENT)


def test_what_validation_readings_contradict_is_said_and_certain_no_more(contradicted):
    found = contradicted

    # they decide nothing: that would make them readings that chose the model
    assert [(one.effect, one.confidence) for one in found.findings] == [("joint_gain", Confidence.LIKELY)]
    assert found.withdrawn == ()
    assert found.verdict is Verdict.PARTLY_EXPLAINED
    assert found.after.rms_mm > found.before.rms_mm
    assert english(found.remaining.sentence).startswith("The validation readings contradict the findings")
    assert english(found.remaining.sentence) in english(found.message)
    # nobody is given a model that is known to be worse
    assert "gain_4" not in [parameter.name for parameter in found.model.parameters]


def test_validation_readings_choose_nothing(contradicted, explained):
    """Whatever they say, the same is found; only what is said of it changes."""
    found = contradicted

    assert [one.parameters for one in found.findings] == [one.parameters for one in explained.findings]
    assert found.findings[0].amplitude == explained.findings[0].amplitude


def test_without_validation_readings_nothing_is_contradicted_and_the_cause_stays_in_the_model():
    """Fewer readings show too little of so weak a wave for a fold to choose it: that refutes nothing."""
    weak = {"joint_harmonics": {"wave_4_5_sin": 2.2e-4}}

    found = diagnose(planted(weak, telling_campaign(30, seed=37), seed=37), PRESENT)

    assert [(one.effect, one.subject) for one in found.findings] == [("joint_harmonics", "joint 4")]
    assert (found.held_out, found.remaining.structure) == ("cross_validation", False)
    assert found.after.rms_mm >= found.before.rms_mm
    assert set(found.findings[0].parameters) <= {parameter.name for parameter in found.model.parameters}


def test_what_cannot_be_fitted_is_answered_with_its_reason():
    few = planted(GAIN_4, telling_campaign(5))

    found = diagnose(few, PRESENT)

    assert found.verdict is Verdict.UNEXPLAINED
    assert "5" in english(found.message)
    assert english(found.remaining.sentence) == english(found.message)
    assert (found.findings, found.before, found.after, found.errors, found.model) == (
        (),
        None,
        None,
        None,
        None,
    )


def test_an_answer_without_numbers_names_robot_and_quantity(campaign):
    found = unanswerable(campaign, PRESENT, "Nothing can be said.")

    assert (found.robot, found.quantity, found.start_effects) == ("ABB IRB 120", "position", PRESENT)
    assert english(found.message) == "Nothing can be said."


def off_at(rows):
    """What is said where some readings of a sound robot are off by 0.3 mm."""
    return diagnose(shifted(with_unseen({}), rows, 0.3), PRESENT)


def test_bad_readings_that_fall_anywhere_are_certain():
    diagnosis = off_at(np.array([3, 17, 28, 44, 58, 71]))
    (finding,) = diagnosis.findings

    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.effect, finding.confidence) == ("outliers", Confidence.CERTAIN)
    assert english(finding.sentence).endswith("or measure them again.")


def test_bad_readings_that_gather_are_not_certain_and_what_they_share_is_left():
    """A nest that came loose in one mounting is no reflector that was not seated."""
    points = with_unseen({}).calibration
    loose = np.flatnonzero((points.nest == 2) & (points.stops.attachment == 3))

    diagnosis = off_at(loose)
    (finding,) = diagnosis.findings

    assert diagnosis.verdict is Verdict.PARTLY_EXPLAINED
    assert (finding.effect, finding.confidence) == ("outliers", Confidence.LIKELY)
    assert "taken at nest 2 in mounting 3 of the tool" in english(finding.sentence)
    assert [one.variable for one in diagnosis.remaining.depends_on] == ["nest and attachment of the tool"]
    assert diagnosis.remaining.described == ()
    assert np.array_equal(diagnosis.errors.before_mm, diagnosis.errors.after_mm)


def test_bad_readings_beside_what_nothing_explains_are_not_certain():
    """One more than is wrong gets no weight here: it is what the model lacks."""
    slight = with_unseen({"joint_gain": {"gain_4": 2e-4}})
    wrong = np.array([3, 17, 28, 44, 58, 71])

    diagnosis = diagnose(
        shifted(slight, wrong, 1.0),
        START,
        without=("joint_gain", "joint_harmonics", "joint_coupling", "unnamed"),
    )
    (finding,) = diagnosis.findings

    assert diagnosis.remaining.structure
    assert (finding.effect, finding.confidence) == ("outliers", Confidence.LIKELY)
    assert finding.details[0].value > len(wrong)
    assert finding.gain.interval_95_mm[0] > 0.0
