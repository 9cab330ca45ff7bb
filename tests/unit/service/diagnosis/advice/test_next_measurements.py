"""What is proposed: actions and configurations by the causes in doubt, and by what is left."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import make_selected, make_start
from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import configurations
from truepose.diagnosis.evidence.residual_structure import Relation, Remainder
from truepose.diagnosis.next_measurements import action_for, next_measurements
from truepose.diagnosis.reading_faults import Tails
from truepose.domain.diagnosis import Cause, Confidence, Finding
from truepose.domain.robot import JointRange
from truepose.effects.registry import CAUSES
from truepose.messages.catalogue import english

GAIN = ("joint_gain", "joint 4")
COUPLING = ("joint_coupling", "joint 4")
WAVE = ("joint_harmonics", "joint 4", "wave_4_1_sin")


@pytest.fixture(scope="module")
def start():
    return make_start({"joint_gain": {"gain_4": 1e-3}})


def make_finding(pick, *rivals):
    return Finding(
        effect=pick.effect,
        subject=pick.subject,
        amplitude=1.0,
        unit="1",
        amplitude_standard_uncertainty=0.1,
        p_value=1e-6,
        confidence=Confidence.LIKELY,
        details=(),
        sentence="",
        confusable_with=tuple(Cause(*rival[:2]) for rival in rivals),
        gain=None,
        parameters=pick.names,
        share=1.0,
    )


def make_left(*depends, more_than_stated=False):
    none = Tails(np.zeros(80, dtype=bool), None)
    return Remainder(tuple(depends), 1.0, more_than_stated, False, none)


def proposed(start, picked=(), rivals=(), left=None):
    """What is proposed for the first pick with these rivals."""
    selected = make_selected(start, picked, rivals)
    groups = tuple((pick.subject, (pick,)) for pick in selected.picks)
    findings = tuple(make_finding(pick, *rivals) for pick in selected.picks[:1])
    return next_measurements(start, selected, groups, findings, left or make_left())


def test_nothing_is_proposed_where_nothing_is_in_doubt(start):
    assert proposed(start, [GAIN]) == ()


def test_rivals_of_the_angle_are_told_apart_by_configurations(start):
    (proposal,) = proposed(start, [GAIN], [COUPLING])

    assert set(proposal.separates) == {Cause(*GAIN), Cause(*COUPLING)}
    assert 3 <= len(proposal.configurations_deg) <= 5
    assert {len(row) for row in proposal.configurations_deg} == {6}
    assert "configurations as the instrument can see" in english(proposal.sentence)


def test_the_same_data_get_the_same_answer(start):
    assert proposed(start, [GAIN], [COUPLING]) == proposed(start, [GAIN], [COUPLING])


def test_a_hardly_visible_gain_is_told_from_a_wave_by_a_wider_range_only():
    start = make_start({"joint_gain": {"gain_4": 2e-5}})

    (proposal,) = proposed(start, [GAIN], [WAVE])

    # Over +-90 deg the two differ by a few um: no five readings of 15 um each would show it.
    assert proposal.configurations_deg == ()
    assert english(proposal.sentence).startswith("Measure with joint 4 beyond its measured range (-")
    assert set(proposal.separates) == {Cause(*GAIN), Cause(*WAVE[:2])}


def test_where_the_limits_allow_it_farther_configurations_are_proposed():
    narrow = 0.2 * configurations(80)
    wide = tuple(JointRange(np.deg2rad(-160.0), np.deg2rad(160.0)) for _ in range(6))
    robot = replace(IRB_120, joint_limits=wide)
    campaign = telling_campaign(robot=robot, joints_rad=narrow, n=80)
    start = make_start({"joint_gain": {"gain_4": 1e-3}}, campaign=campaign)

    (proposal,) = proposed(start, [GAIN], [WAVE])

    reached = np.abs(np.array(proposal.configurations_deg))
    assert "beyond the joint ranges measured so far" in english(proposal.sentence)
    assert reached.max() <= 160.0
    assert (reached.max(axis=0) > np.rad2deg(np.abs(narrow).max(axis=0))).any()


def test_joints_that_stood_still_are_to_be_moved_first():
    joints = configurations(80)
    joints[:, [2, 4]] = 0.0
    start = make_start({"joint_gain": {"gain_4": 1e-3}}, campaign=telling_campaign(80, joints_rad=joints))

    first, *_ = proposed(start, [GAIN], [COUPLING])

    assert english(first.sentence).startswith("Also move joints 3 and 5")
    assert set(first.separates) == {Cause(*GAIN), Cause(*COUPLING)}


def test_of_many_dependences_the_first_two_are_looked_into(start):
    left = make_left(*(depends("angle", joint) for joint in (1, 2, 3, 4)))

    assert len(proposed(start, left=left)) == 2


@pytest.mark.parametrize(
    ("own", "rival", "said", "again"),
    [
        ("backlash", "joint_harmonics", "from below and once from above", False),
        ("base_drift", "base_shift", "first configurations again at the end", True),
        ("base_drift", "instrument_drift", "reference nests", False),
        ("thermal_growth", "base_drift", "warmed up", True),
        ("tool_reseating", "base_drift", "mount it again", True),
        ("nest_offset", "joint_gain", "every nest", False),
        ("payload", "link_mass", "with the load and without it", False),
    ],
)
def test_causes_that_no_configuration_tells_apart_get_an_action(start, own, rival, said, again):
    selected = make_selected(start, [GAIN])
    subject = "nest 1" if own == "nest_offset" else "joint 1"
    causes = Cause(own, subject), Cause(rival, "joint 2")
    finding = replace(
        make_finding(selected.picks[0]), effect=own, subject=subject, confusable_with=causes[1:]
    )

    (proposal,) = next_measurements(start, selected, (), (finding,), make_left())

    assert said in english(proposal.sentence)
    assert proposal.separates == causes
    assert len(proposal.configurations_deg) == (5 if again else 0)


def test_two_findings_in_doubt_of_each_other_are_one_proposal(start):
    selected = make_selected(start, [GAIN])
    drift, jump = Cause("base_drift", "base"), Cause("base_shift", "base")
    one, other = (
        replace(make_finding(selected.picks[0]), effect=own.effect, subject="base", confusable_with=(rival,))
        for own, rival in ((drift, jump), (jump, drift))
    )

    (proposal,) = next_measurements(start, selected, (), (one, other), make_left())

    assert proposal.separates == (drift, jump)


def test_every_pair_of_causes_gets_an_action_or_configurations():
    static = {
        "axis_parallelism", "base_compliance", "compliance", "compliance_nonlinear", "instrument_scale",
        "joint_coupling", "joint_gain", "joint_harmonics", "label_swap", "link_bending", "link_mass",
        "outliers", "payload", "unnamed",
    }  # fmt: skip

    subjects = {
        "fixture_shift": "placement 1",
        "nest_offset": "nest 2",
        "unnamed": "joint 1, angle of joint 2, wave",
    }
    for effect in CAUSES:
        action = action_for(Cause(effect, subjects.get(effect, "joint 2")), Cause("joint_gain", "joint 1"))
        assert (action is None) == (effect in static), effect


@pytest.mark.parametrize(
    ("subject", "said"),
    [
        ("joint 3, time, jump", "at the end"),
        ("link 2, temperature, line", "warmed up"),
        ("joint 3, torque of joint 3, sign", "from below"),
        ("tracker, time, jump", "reference nests"),
        ("joint 2, last move, line", "in a different order"),
    ],
)
def test_a_cause_without_a_name_gets_the_action_of_its_variable(subject, said):
    action = action_for(Cause("unnamed", subject), Cause("joint_gain", "joint 1"))

    assert said in english(action.do)


def depends(kind, joint=None, order=0.0):
    return Relation(f"{kind} of something", 1e-4, kind, joint, None, order)


def test_an_unknown_dependence_on_an_angle_is_filled_where_it_has_gaps(start):
    (proposal,) = proposed(start, left=make_left(depends("angle", 3)))

    measured = np.sort(np.rad2deg(start.scene.stops.joints_rad[:, 3]))
    largest = np.argsort(-np.diff(measured))[:5]
    angles = np.array(proposal.configurations_deg)[:, 3]
    inside = [any(measured[gap] < angle < measured[gap + 1] for gap in largest) for angle in angles]
    # Farthest points are middles of gaps; the second half of a huge gap may still beat the fifth.
    assert sum(inside) >= 4
    assert proposal.separates == ()


def test_an_unknown_fast_wave_is_stepped_through(start):
    (proposal,) = proposed(start, left=make_left(depends("angle", 5, 100.0)))

    assert np.ptp(np.array(proposal.configurations_deg)[:, 5]) == pytest.approx(0.8 * 3.6, abs=0.011)
    assert "one period" in english(proposal.sentence)


@pytest.mark.parametrize(
    ("kind", "joint", "count"),
    [("torque", 1, 5), ("place", None, 5), ("coupling", 4, 5), ("time", None, 5), ("temperature", None, 5),
     ("attachment", None, 5), ("direction", 2, 0), ("nest", None, 0)],
)  # fmt: skip
def test_every_unknown_dependence_gets_something_to_do(start, kind, joint, count):
    (proposal,) = proposed(start, left=make_left(depends(kind, joint)))

    assert len(proposal.configurations_deg) == count
    assert f"residuals depend on the {kind} of something" in english(proposal.sentence)


def test_noise_beyond_what_is_stated_asks_for_revisits_where_there_were_none(start):
    (proposal,) = proposed(start, left=make_left(more_than_stated=True))

    first = np.rad2deg(start.scene.stops.joints_rad[:5])
    # Configurations are told in whole hundredths of a degree.
    assert np.array(proposal.configurations_deg) == pytest.approx(first, abs=0.0051)


def test_revisits_that_were_made_are_not_asked_for_again(start):
    n = len(start.scene.stops)
    repeat_of = np.where(np.arange(n) >= n - 5, 1, -1)
    again = replace(start, scene=replace(start.scene, stops=replace(start.scene.stops, repeat_of=repeat_of)))

    assert proposed(again, left=make_left(more_than_stated=True)) == ()


@pytest.mark.parametrize("left", [make_left(), make_left(more_than_stated=True)])
def test_two_waves_of_a_joint_are_told_from_their_rival_by_one_proposal(left):
    """Of noise beyond what is stated revisits are asked for besides."""
    start = make_start({"joint_harmonics": {"wave_4_1_sin": 2e-5, "wave_4_2_sin": 2e-5}})
    waves = [(*WAVE[:2], f"wave_4_{order}_sin") for order in (1, 2)]
    selected = make_selected(start, waves, [GAIN])
    findings = tuple(make_finding(pick, GAIN) for pick in selected.picks)
    groups = tuple((pick.subject, (pick,)) for pick in selected.picks)

    proposals = next_measurements(start, selected, groups, findings, left)

    assert len(proposals) == len(set(proposals)) == 1 + left.structure
