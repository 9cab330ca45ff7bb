"""Corrected joint targets against the forward model, whose own truth is the simulator's affair."""

from dataclasses import fields, replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import (
    EXTENSIONS,
    LOADED_SEVEN_AXES,
    extended,
    model_of,
    parameters_of,
    plain_parameters,
)
from tests.helpers.identification.synthetic import configurations
from truepose.correction import (
    ANY_BRANCH,
    FLANGE,
    Goals,
    Summary,
    correct,
    flange_in_base,
    goals_of_joints,
    of_poses,
    tool_nests_mm,
)
from truepose.correction.results import Corrections
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import predict
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import branch_of
from truepose.kinematics.poses import turn_between

UM, URAD = 1e-3, 1e-6
PLAIN = model_of(IRB_120, *plain_parameters(IRB_120))
LIMITED = replace(IRB_120, joint_limits=tuple(JointRange(-3.2, 3.2) for _ in range(6)))


def reached(model, stops, nest):
    """Where the tool is: of nest 0 the flange frame itself."""
    structure = structure_of(model)
    structure = replace(structure, nests_mm=np.vstack([structure.nests_mm, np.zeros(3)]))
    numbered = np.where(nest == FLANGE, len(structure.nests_mm), nest)
    state = evaluate(structure, values_of(model), Targets(stops, numbered))
    return state.unscaled_mm, state.chain.end_rotation


def goals_at(model, stops, nest, start_rad=None):
    position, rotation = reached(model, stops, nest)
    unknown = np.full_like(stops.joints_rad, np.nan) if start_rad is None else start_rad
    return Goals(replace(stops, joints_rad=unknown), nest, position, rotation)


def plain_goals(model, n=40, seed=0, start_rad=None):
    stops = Stops(np.arange(n), configurations(n, seed))
    return goals_at(model, stops, np.arange(n) % 3, start_rad)


def assert_there(model, goals, found):
    position, rotation = reached(model, goals.at(found.joints_rad), goals.nest)
    assert np.abs(position - goals.position_mm).max() < UM
    assert turn_between(rotation, goals.rotation).max() < URAD


def test_a_robot_without_errors_is_sent_where_its_controller_would_go():
    joints = configurations(50)
    chain = nominal_chain(IRB_120, joints)
    pose = np.tile(np.eye(4), (50, 1, 1))
    pose[:, :3, :3], pose[:, :3, 3] = chain.end_rotation, chain.end_origin

    nothing = model_of(IRB_120, base=model_of().nominal_base, effects=())
    found = correct(nothing, of_poses(pose, 6), branch_of(IRB_120, joints))

    assert found.joints_rad == pytest.approx(joints, abs=1e-9)


@pytest.mark.parametrize("effect", sorted(EXTENSIONS))
def test_every_effect_is_made_up_for(effect):
    model = extended(IRB_120, effect)
    rng = np.random.default_rng(3)
    stops = Stops(
        np.arange(30),
        configurations(30, 4),
        direction=rng.choice([-1, 1], (30, 6)),
        time_s=np.linspace(500.0, 4000.0, 30),
        temperature_c=rng.uniform(18.0, 30.0, 30),
        attachment=rng.integers(1, 3, 30),
    )
    goals = goals_at(model, stops, np.arange(30) % 3)

    found = correct(model, goals)

    assert found.solved.all()
    assert_there(model, goals, found)


def test_all_branches_of_a_goal_are_reached_where_they_are_within_the_limits():
    model = model_of(LIMITED, *plain_parameters(LIMITED))
    one = plain_goals(model, 1, seed=5)
    goals = one.taken(np.zeros(8, dtype=np.int64))

    found = correct(model, goals, np.arange(8))

    assert found.solved.all()
    assert found.branch.tolist() == list(range(8))
    assert_there(model, goals, found)


@pytest.mark.parametrize("branch", [8, 9, -2])
def test_a_branch_that_no_arm_has_is_refused(branch):
    goals = plain_goals(PLAIN, 3)

    with pytest.raises(ConfigurationError, match=f"^Branch {branch} is unknown"):
        correct(PLAIN, goals, np.array([0, branch, ANY_BRANCH]))


def test_an_arm_without_numbered_branches_is_asked_for_none():
    model = model_of(LOADED_SEVEN_AXES, *plain_parameters(LOADED_SEVEN_AXES))
    joints = np.random.default_rng(9).uniform(0.3, 1.2, (3, 7))
    stops, nest = Stops(np.arange(3), joints), np.ones(3, dtype=np.int64)

    with pytest.raises(ConfigurationError, match="has no numbered branches"):
        correct(model, goals_at(model, stops, nest), np.array([ANY_BRANCH, 0, ANY_BRANCH]))
    assert correct(model, goals_at(model, stops, nest, joints), np.zeros(3, dtype=np.int64)).solved.all()


def test_without_a_wish_the_branch_is_that_of_the_calibration():
    found = correct(PLAIN, plain_goals(PLAIN, 200))

    assert found.solved.all()
    low, high = (
        np.array(ends)
        for ends in zip(*((r.lower_rad, r.upper_rad) for r in IRB_120.calibration_ranges), strict=True)
    )
    within = ((found.joints_rad > low - 0.1) & (found.joints_rad < high + 0.1)).all(axis=1)
    assert within.mean() > 0.95


def test_near_a_singular_wrist_the_goal_is_reached_all_the_same():
    joints = configurations(300, 6)
    joints[:, 4] = np.random.default_rng(7).uniform(-2e-3, 2e-3, 300)
    goals = goals_at(PLAIN, Stops(np.arange(300), joints), np.zeros(300, dtype=np.int64))

    found = correct(PLAIN, goals)

    assert found.solved.mean() > 0.99
    some = np.flatnonzero(found.solved)
    assert_there(PLAIN, goals.taken(some), found.taken(some))


def test_the_answer_stays_near_the_joints_that_are_told_whole_turns_included():
    told = configurations(30, 8)
    told[:, 5] += 2 * np.pi
    goals = plain_goals(PLAIN, 30, seed=8, start_rad=told + 2e-3)

    found = correct(PLAIN, goals)

    assert found.solved.all()
    assert np.abs(found.joints_rad - told).max() < 0.1


def test_a_tool_that_is_half_a_turn_off_is_not_there():
    nothing = model_of(IRB_120, base=model_of().nominal_base, effects=())
    told = configurations(10, 8)
    goals = plain_goals(nothing, 10, seed=8, start_rad=told + np.pi * np.eye(6)[5])

    found = correct(nothing, goals)

    assert found.solved.all()
    assert_there(nothing, goals, found)


def test_an_arm_of_seven_axes_is_corrected_from_the_joints_that_are_told():
    model = model_of(LOADED_SEVEN_AXES, *plain_parameters(LOADED_SEVEN_AXES))
    joints = np.random.default_rng(9).uniform(0.3, 1.2, (20, 7))
    goals = goals_at(model, Stops(np.arange(20), joints), np.ones(20, dtype=np.int64), joints + 5e-3)

    found = correct(model, goals)

    assert found.solved.all()
    assert_there(model, goals, found)
    assert np.abs(found.joints_rad - joints).max() < 0.05


def test_a_goal_out_of_reach_is_told_apart_from_one_at_a_limit_and_neither_hands_out_joints():
    limited = replace(IRB_120, joint_limits=tuple(JointRange(-0.5, 0.5) for _ in range(6)))
    model = model_of(limited, *plain_parameters(limited))
    joints = np.tile([0.2, 0.3, -0.2, 0.4, 0.45, 0.1], (3, 1))
    joints[1, 0] = 0.7
    goals = goals_at(model, Stops(np.arange(3), joints), np.zeros(3, dtype=np.int64))
    goals.position_mm[2] += [2000.0, 0.0, 0.0]

    found = correct(model, goals)
    from_told = correct(model, goals_at(model, goals.at(joints), goals.nest, joints))

    assert found.status.tolist() == ["ok", "joint_limit", "out_of_reach"]
    assert found.beyond_limit_rad[1, 0] == pytest.approx(0.2, abs=0.02)
    assert found.error_mm[2] > 500.0
    for answer in (found, from_told):
        assert not answer.solved.all()
        assert np.isfinite(answer.joints_rad).all(axis=1).tolist() == answer.solved.tolist()
        assert (answer.branch == ANY_BRANCH).tolist() == (~answer.solved).tolist()


def test_a_gap_is_made_up_for_by_the_direction_of_approach():
    model = model_of(IRB_120, *parameters_of("backlash", [("gap_2", 5e-4, "rad")]))
    joints = np.array([0.2, 0.3, -0.2, 0.4, 0.8, 0.1]) + 0.1 * np.arange(5)[:, None]
    ways = [Stops(np.arange(5), joints, direction=np.full((5, 6), sign)) for sign in (-1, 1)]
    nest = np.ones(5, dtype=np.int64)
    same = goals_at(model, ways[0], nest)

    down, up = (
        correct(model, replace(same, stops=replace(way, joints_rad=joints))).joints_rad for way in ways
    )

    assert np.abs(up - down)[:, 1] == pytest.approx(np.full(5, 5e-4), rel=1e-3)


def test_an_instrument_that_reads_too_long_leaves_the_targets_alone():
    goals, scaled = plain_goals(PLAIN), extended(IRB_120, "instrument_scale")

    assert correct(scaled, goals).joints_rad == pytest.approx(correct(PLAIN, goals).joints_rad, abs=1e-12)


def test_the_uncertainty_is_that_of_the_prediction_and_the_turn_that_of_the_parameters():
    known = model_of(
        IRB_120,
        *parameters_of("geometry", [("a_3", 0.2, "mm"), ("theta_2", 1e-3, "rad")]),
        covariance=np.diag([0.02**2, 1e-4**2]),
        discrepancy_mm=0.03,
    )
    goals = plain_goals(known)
    goals = goals.taken(np.flatnonzero(goals.nest != FLANGE))

    found = correct(known, goals)

    _, expected = predict(known, goals.at(found.joints_rad), goals.nest)
    assert found.uncertainty_mm == pytest.approx(expected, rel=1e-9)
    assert found.uncertainty_rad == pytest.approx(np.full(len(goals), 1e-4 / np.sqrt(3.0)), rel=1e-6)


def test_more_goals_than_are_taken_at_once_come_back_in_order(monkeypatch):
    monkeypatch.setattr("truepose.correction.joint_targets._AT_ONCE", 7)
    goals = plain_goals(PLAIN, 20)

    found = correct(PLAIN, goals)

    assert_there(PLAIN, goals, found)


def test_no_goal_is_no_row():
    assert len(correct(PLAIN, plain_goals(PLAIN, 3).taken(np.zeros(0, dtype=np.int64)))) == 0


@pytest.mark.parametrize("nest", [-1, 9])
def test_a_nest_that_the_model_does_not_know_is_refused(nest):
    with pytest.raises(ConfigurationError, match=f"Nest {nest} is unknown"):
        correct(PLAIN, replace(plain_goals(PLAIN, 3), nest=np.full(3, nest)))


def nestless_model():
    parameters = (parameter for parameter in plain_parameters(IRB_120) if parameter.effect != "tool")
    return model_of(IRB_120, *parameters, nests=(), nominal_nests=())


def test_a_model_without_nests_is_corrected_at_its_flange():
    nestless = nestless_model()
    stops = Stops(np.arange(10), configurations(10, 3))
    goals = goals_at(nestless, stops, np.full(10, FLANGE))

    found = correct(nestless, goals)

    assert found.solved.all()
    assert_there(nestless, goals, found)
    with pytest.raises(ConfigurationError, match=r"^Nest 1 is unknown: the model has no nests\.$"):
        correct(nestless, replace(goals, nest=np.ones(10, dtype=np.int64)))


def test_a_model_without_nests_has_a_base_and_places_no_nest():
    nestless = nestless_model()
    stops = Stops(np.arange(3), configurations(3))
    goals = goals_of_joints(nestless, stops)

    assert tool_nests_mm(nestless).shape == (0, 3)
    assert flange_in_base(nestless, goals)[:, :3, 3] == pytest.approx(
        nominal_chain(IRB_120, stops.joints_rad).end_origin
    )


@pytest.mark.parametrize(
    ("value", "said"),
    [(np.nan, "not a rotation"), (np.inf, "not a rotation"), (1.1, "not a rotation"), (-1.0, "left-handed")],
)
def test_what_is_no_rotation_is_refused_with_its_row(value, said):
    pose = np.tile(np.eye(4), (3, 1, 1))
    pose[1, 0, 0] = value

    with pytest.raises(ConfigurationError, match=f"row 1 is {said}"):
        of_poses(pose, 6)


def test_how_far_joints_turn_from_the_controllers_own_answer_is_told():
    usual, singular = configurations(20, 11), configurations(20, 12)
    usual[:, 4], singular[:, 4] = 0.8, 1e-4

    few, many = (
        correct(PLAIN, goals_at(PLAIN, Stops(np.arange(20), joints), np.zeros(20, dtype=np.int64))).moved_rad
        for joints in (usual, singular)
    )

    assert np.nanmax(few) < 0.05
    assert np.nanmax(many) > 0.2


def rows(status, **columns):
    """Rows of two joints; what is not said is nothing."""
    n = len(status)
    usual = {field.name: np.zeros(n) for field in fields(Corrections)}
    usual |= {name: np.zeros((n, 2)) for name in ("joints_rad", "outside_rad", "beyond_limit_rad")}
    return Corrections(**usual | {"status": np.array(status)} | columns)


def test_a_summary_counts_rows_over_several_parts():
    summary = Summary()
    far = np.radians([5.1, 4.9, 90.0])
    summary.add(
        ["A", "B", "C"],
        rows(
            ["ok", "limits_unknown", "out_of_reach"],
            error_mm=np.array([1e-4, 3e-4, 9.0]),
            uncertainty_mm=np.array([0.02, 0.05, 9.0]),
            moved_rad=far,
            outside_mm=np.array([0.0, 7.0, 99.0]),
        ),
    )
    summary.add(
        ["D", "E"],
        rows(
            ["ok", "singular"],
            uncertainty_mm=np.array([0.05, 0.0]),
            moved_rad=np.array([np.nan, 0.0]),
            outside_rad=np.array([[0.0, 0.3], [0.0, 0.0]]),
        ),
    )

    totals = summary.totals

    assert totals.statuses == {"ok": 2, "limits_unknown": 1, "out_of_reach": 1, "singular": 1}
    assert (totals.targets, totals.solved) == (5, 3)
    assert totals.failed == (("C", "out_of_reach"), ("E", "singular"))
    assert totals.largest_error_mm == 3e-4
    assert totals.mean_uncertainty_mm == pytest.approx(0.04)
    assert totals.largest_uncertainty_mm == 0.05
    assert (totals.far_moved, totals.largest_move_rad) == (1, far[0])
    assert (totals.outside, totals.farthest_outside_mm, totals.farthest_outside_rad) == (2, 7.0, 0.3)
    assert totals.zone_known


def test_a_summary_names_the_first_hundred_that_failed_and_says_where_no_zone_is_known():
    summary = Summary()
    for part in range(3):
        summary.add([f"{part}-{k}" for k in range(60)], rows(["singular"] * 60))
    summary.add(["last"], rows(["ok"], outside_mm=np.array([np.nan])))

    totals = summary.totals

    assert len(totals.failed) == 100
    assert totals.failed[-1] == ("1-39", "singular")
    assert not totals.zone_known
    assert totals.outside == 0
