"""Causes in joints and between their axes: when they are looked for, what they do, what they are called."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    fitted,
    rows_at_start,
    start_for,
    telling_campaign,
    telling_problem,
    telling_scene,
    without_masses,
)
from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.domain.robot import JointRow
from truepose.effects.causes import FittedCause
from truepose.effects.registry import CAUSES
from truepose.effects.waves import orders
from truepose.identification.model.evaluation import evaluate
from truepose.identification.problem.build import build
from truepose.kinematics.gravity import gravity_torques
from truepose.messages.catalogue import english


def scene_for(cause, campaign=None, **changes):
    return telling_scene(start_for(cause), campaign, **changes)


def with_stops(scene, **columns):
    return replace(scene, stops=replace(scene.stops, **columns))


def seven_axes(seed=7, **changes):
    joints = np.random.default_rng(seed).uniform(-1.5, 1.5, (24, 7))
    return telling_campaign(robot=SEVEN_AXES, joints_rad=joints, **changes)


def places(campaign, effects, **values):
    """Where the nests are with these parameters and no other errors."""
    problem = build(campaign, effects)
    full = np.zeros(len(problem.start))
    for name, value in values.items():
        full[problem.structure.index_of(name)] = value
    return evaluate(problem.structure, full, problem.blocks[0].targets).position_mm


def test_without_parallel_axes_there_is_no_parallelism_to_lack():
    scene = scene_for("axis_parallelism", seven_axes())

    assert "no axis of this robot" in english(CAUSES["axis_parallelism"].unseen(scene))
    assert CAUSES["axis_parallelism"].candidates(scene) == ()


def test_a_tilt_is_the_hayati_beta_of_the_later_axis_whatever_its_sign():
    shown = CAUSES["axis_parallelism"].describe(
        "joint 3",
        fitted(("beta_3", -np.deg2rad(0.02)), spread=np.deg2rad(0.001)),
        scene_for("axis_parallelism"),
    )

    assert shown.amplitude == pytest.approx(0.02)
    assert shown.unit == "deg"
    assert shown.standard_uncertainty == pytest.approx(0.001)
    assert shown.details[0].value == pytest.approx(-0.02)
    assert "axes of joints 2 and 3 are not parallel" in english(shown.sentence)


def test_a_wrist_joint_follows_the_angle_of_its_source_as_the_controller_counts_both():
    """Joints 2 and 5 of this robot count against their axes."""
    campaign = seven_axes()
    joints = campaign.calibration.stops.joints_rad
    dragged = joints.copy()
    dragged[:, 4] += 1e-3 * joints[:, 1]

    problem = build(campaign, ("base",))
    structure = problem.structure.extended("joint_coupling", coupling_specs("coupling_5_2"))
    moved = evaluate(structure, np.append(problem.start, 1e-3), problem.blocks[0].targets).position_mm

    there = telling_campaign(robot=SEVEN_AXES, joints_rad=dragged).calibration.position_mm
    assert moved == pytest.approx(there, abs=1e-9)  # rounding of a metre is 1e-13 mm


def coupling_specs(*names):
    candidates = CAUSES["joint_coupling"].candidates(telling_scene(("base",), seven_axes()))
    return tuple(spec for candidate in candidates for spec in candidate.specs if spec.name in names)


def test_only_wrist_joints_are_dragged_and_only_joints_that_turn_drag():
    scene = scene_for("joint_coupling")
    still = scene.turn_rad.copy()
    still[:, 4] = 0.3
    candidates = CAUSES["joint_coupling"].candidates(replace(scene, turn_rad=still))

    assert {candidate.subject for candidate in candidates} == {"joint 4", "joint 5", "joint 6"}
    assert {candidate.variant for candidate in candidates} == {1.0, 2.0, 3.0, 4.0, 6.0}
    assert len(candidates) == 4 + 5 + 4  # joint 5 does not turn: it drags neither 4 nor 6


def test_a_coupling_names_its_source():
    shown = CAUSES["joint_coupling"].describe(
        "joint 6", fitted(("coupling_6_5", -5e-4), spread=2e-5), scene_for("joint_coupling")
    )

    assert (shown.amplitude, shown.unit, shown.standard_uncertainty) == (
        -5e-4,
        "rad/rad",
        pytest.approx(2e-5),
    )
    assert [(detail.name, detail.value) for detail in shown.details] == [("source joint", 5.0)]
    assert "Joint 6 also turns when joint 5 moves" in english(shown.sentence)


def test_a_gap_keeps_a_joint_from_where_it_is_sent_also_where_it_counts_against_its_axis():
    campaign = seven_axes()
    stops = campaign.calibration.stops
    gap = np.deg2rad(0.05)

    moved = places(campaign, ("base", "backlash"), gap_2=gap, gap_7=gap)

    short = stops.joints_rad.copy()
    short[:, [1, 6]] -= 0.5 * gap * stops.direction[:, [1, 6]]
    there = telling_campaign(robot=SEVEN_AXES, joints_rad=short).calibration.position_mm
    assert moved == pytest.approx(there, abs=1e-9)


def test_a_joint_of_unknown_direction_stands_in_the_middle_of_its_gap():
    campaign = telling_campaign()
    unknown = replace(
        campaign,
        calibration=replace(campaign.calibration, stops=replace(campaign.calibration.stops, direction=None)),
    )

    for rows in (unknown, with_no_direction(campaign)):
        assert places(rows, ("base", "backlash"), gap_3=1e-3) == pytest.approx(
            campaign.calibration.position_mm, abs=1e-9
        )


def with_no_direction(campaign):
    stops = campaign.calibration.stops
    return replace(
        campaign,
        calibration=replace(
            campaign.calibration, stops=replace(stops, direction=np.zeros_like(stops.direction))
        ),
    )


@pytest.mark.parametrize("direction", [None, np.ones((24, 6), dtype=int), np.zeros((24, 6), dtype=int)])
def test_backlash_is_not_seen_unless_joints_came_from_both_sides(direction):
    scene = with_stops(scene_for("backlash"), direction=direction)

    assert "both sides" in english(CAUSES["backlash"].unseen(scene)) or "other side" in english(
        CAUSES["backlash"].unseen(scene)
    )
    assert CAUSES["backlash"].candidates(scene) == ()


def test_backlash_is_looked_for_in_joints_from_both_sides_and_in_all_of_them_together():
    scene = scene_for("backlash")
    direction = scene.stops.direction.copy()
    direction[:, 2] = 1
    candidates = CAUSES["backlash"].candidates(with_stops(scene, direction=direction))

    assert [candidate.subject for candidate in candidates] == [f"joint {k}" for k in (1, 2, 4, 5, 6)] + [
        "joints"
    ]
    assert candidates[-1].names == ("gap_1", "gap_2", "gap_4", "gap_5", "gap_6")


def test_of_many_gaps_the_widest_is_the_amplitude():
    shown = CAUSES["backlash"].describe(
        "joints",
        fitted(("gap_1", 1e-4), ("gap_4", 6e-4), ("gap_6", 3e-4), spread=1e-5),
        scene_for("backlash"),
    )

    assert shown.amplitude == pytest.approx(np.rad2deg(6e-4))
    assert shown.standard_uncertainty == pytest.approx(np.rad2deg(1e-5))
    assert [detail.name for detail in shown.details] == ["gap of joint 1", "gap of joint 4", "gap of joint 6"]
    assert "The largest is that of joint 4" in english(shown.sentence)


def test_springs_are_looked_for_in_every_joint_that_gravity_loads():
    subjects = [candidate.subject for candidate in CAUSES["compliance"].candidates(scene_for("compliance"))]

    assert subjects == [f"joint {k}" for k in range(2, 7)]  # the axis of joint 1 is along gravity


def test_without_masses_the_moments_of_the_heavy_links_are_tried_before_all_of_them():
    """Joint 2 has ten products; four of them carry nearly all of its load."""
    scene = telling_scene(("base", "geometry"), telling_campaign(robot=without_masses()))
    candidates = CAUSES["compliance"].candidates(scene)

    by_subject = [(candidate.subject, len(candidate.names)) for candidate in candidates]

    assert by_subject == [
        ("joint 2", 4), ("joint 2", 10), ("joint 3", 2), ("joint 3", 8),
        ("joint 4", 6), ("joint 5", 4), ("joint 6", 2),
    ]  # fmt: skip
    assert candidates[2].names == ("c_3*mx_3", "c_3*my_3")


def test_without_masses_a_spring_is_all_its_products_and_its_size_is_the_deflection_that_they_make():
    campaign = telling_campaign(robot=without_masses())
    scene = telling_scene(("base", "geometry"), campaign)
    candidate = next(c for c in CAUSES["compliance"].candidates(scene) if c.subject == "joint 5")
    rows = rows_at_start(build(campaign, ("base", "geometry")))
    values = np.full(len(candidate.names), 1e-6)
    deflection = sum(term.weight * 1e-6 for term in CAUSES["compliance"].terms(candidate.names, rows))

    shown = CAUSES["compliance"].describe(
        "joint 5", FittedCause(candidate.names, values, 1e-24 * np.eye(len(values))), scene
    )

    assert candidate.names == ("c_5*mx_5", "c_5*my_5", "c_5*mx_6", "c_5*my_6")
    assert shown.unit == "deg"
    assert shown.amplitude == pytest.approx(np.rad2deg(np.std(deflection)), rel=1e-6)


def test_a_spring_that_the_model_lacks_is_tried_with_the_weight_that_would_wind_it_up():
    rows = rows_at_start(telling_problem(("base", "geometry")))

    (term,) = CAUSES["compliance"].terms(("c_3",), rows)

    there = gravity_torques(rows.chain, IRB_120.masses, rows.gravity_m_s2)
    assert term.weight == pytest.approx(there[:, 2])


def test_a_spring_says_how_far_it_lets_its_joint_go():
    scene = scene_for("compliance")

    shown = CAUSES["compliance"].describe("joint 3", fitted(("c_3", 1.3e-7), spread=1e-9), scene)

    assert (shown.amplitude, shown.unit, shown.standard_uncertainty) == (1.3e-7, "rad/(N*mm)", 1e-9)
    largest = np.rad2deg(1.3e-7 * np.abs(scene.torque_n_mm[:, 2]).max())
    assert f"up to {largest:.3f} deg" in english(shown.sentence)


def test_a_gear_is_softer_near_zero_torque_and_has_its_own_stiffness_far_beyond():
    scene = scene_for("compliance_nonlinear")
    rows = rows_at_start(telling_problem())
    torque = np.zeros((24, 6))
    torque[:, 2] = np.linspace(-1e5, 1e5, 24)
    torque[11, 2] = 1.0
    torque[5, 2] = np.nan

    (term,) = CAUSES["compliance_nonlinear"].terms(("soft_3_2000",), rows._replace(torque_n_mm=torque))

    assert term.weight[11] == pytest.approx(1.0, rel=1e-6)  # angle over torque is the value itself
    assert term.weight[-1] == pytest.approx(2000.0, rel=1e-6)  # no more than t0 however large the load
    assert term.weight[0] == pytest.approx(-2000.0, rel=1e-6)
    assert term.weight[5] == 0.0  # an unknown load deflects nothing
    assert scene.torque_n_mm is not None


def test_unknown_torques_hide_how_a_gear_bends():
    scene = telling_scene(("base", "geometry"), telling_campaign(robot=without_masses()))

    assert "joint torques are unknown" in english(CAUSES["compliance_nonlinear"].unseen(scene))
    assert CAUSES["compliance_nonlinear"].candidates(scene) == ()


def test_a_joint_is_tried_alone_only_where_its_torque_bends_the_characteristic():
    scene = scene_for("compliance_nonlinear")
    largest = scene.setting.largest_torque_n_mm

    for candidate in CAUSES["compliance_nonlinear"].candidates(scene):
        if candidate.subject != "joints":
            assert largest[int(candidate.subject[-1]) - 1] >= 0.5 * candidate.variant
    assert [c.variant for c in CAUSES["compliance_nonlinear"].candidates(scene) if c.subject == "joints"] == [
        500.0, 1000.0, 2000.0, 4000.0, 8000.0,
    ]  # fmt: skip


def test_softness_is_told_relative_to_the_springs_of_the_model():
    scene = scene_for("compliance_nonlinear")
    springs = scene.softness_rad_per_n_mm
    values = [(f"soft_{joint}_2000", share * springs[joint - 1]) for joint, share in ((2, 0.4), (3, 0.6))]
    names, numbers = zip(*values, strict=True)
    covariance = np.diag([(0.3 * springs[1]) ** 2, (0.1 * springs[2]) ** 2])

    shown = CAUSES["compliance_nonlinear"].describe(
        "joints", FittedCause(names, np.array(numbers), covariance), scene
    )

    # each weighted by its inverse variance: (0.4 / 0.09 + 0.6 / 0.01) / (1 / 0.09 + 1 / 0.01)
    assert shown.amplitude == pytest.approx(0.58)
    assert shown.standard_uncertainty == pytest.approx((1 / 0.09 + 1 / 0.01) ** -0.5)
    assert shown.unit == "1"
    assert "58 % softer below about 2 N*m" in english(shown.sentence)
    assert [(detail.name, detail.value) for detail in shown.details] == [
        ("torque where it ends", 2.0),
        ("share of joint 2", pytest.approx(0.4)),
        ("share of joint 3", pytest.approx(0.6)),
    ]
    alone = CAUSES["compliance_nonlinear"].describe(
        "joint 2", FittedCause(names[:1], np.array(numbers[:1]), covariance[:1, :1]), scene
    )
    assert [detail.name for detail in alone.details] == ["torque where it ends"]


def test_lengths_grow_with_the_temperature_above_20_degrees_and_not_where_it_is_unknown():
    campaign = telling_campaign()
    stops = campaign.calibration.stops
    temperature = np.full(24, 30.0)
    temperature[0] = np.nan
    warm = replace(
        campaign, calibration=replace(campaign.calibration, stops=replace(stops, temperature_c=temperature))
    )

    moved = places(warm, ("base", "thermal_growth"), growth=2e-5)

    grown = replace(IRB_120, joints=tuple(longer(row, 1.0 + 2e-4) for row in IRB_120.joints))
    there = telling_campaign(robot=grown).calibration.position_mm
    assert moved[1:] == pytest.approx(there[1:], abs=1e-9)
    assert moved[0] == pytest.approx(campaign.calibration.position_mm[0], abs=1e-9)


def longer(row, factor):
    return JointRow(row.alpha_rad, factor * row.a_mm, row.theta_offset_rad, factor * row.d_mm, row.sign)


@pytest.mark.parametrize(
    ("temperature", "reason"),
    [
        (None, "have no temperature"),
        (np.full(24, np.nan), "have no temperature"),
        (np.full(24, 23.0), "within 0.0 K"),
    ],
)
def test_growth_is_not_seen_at_one_temperature(temperature, reason):
    scene = with_stops(telling_scene(), temperature_c=temperature)

    assert reason in english(CAUSES["thermal_growth"].unseen(scene))
    assert CAUSES["thermal_growth"].candidates(scene) == ()


def test_growth_is_told_per_metre_and_kelvin():
    shown = CAUSES["thermal_growth"].describe(
        "links", fitted(("growth", 1.8e-5), spread=1e-6), telling_scene()
    )

    assert (shown.amplitude, shown.unit, shown.standard_uncertainty) == (1.8e-5, "1/K", 1e-6)
    assert "18.0 \u00b5m per metre and K" in english(shown.sentence)


@pytest.mark.parametrize(("ratio", "highest"), [(0.2, 2), (1.0, 2), (12.4, 25)])
def test_waves_are_looked_for_up_to_twice_the_gear_and_in_the_joints_own_turn_at_least(ratio, highest):
    scene = telling_scene()
    robot = replace(scene.setting.robot, gear_ratios=(ratio,) * 6)

    tried = orders(replace(scene, setting=scene.setting._replace(robot=robot)), 0)

    assert tried == tuple(range(1, highest + 1))


@pytest.mark.parametrize(("gain", "words"), [(3e-4, "too far"), (-3e-4, "does not turn far enough")])
def test_a_gain_tells_its_way_over_what_was_measured(gain, words):
    scene = scene_for("joint_gain")

    shown = CAUSES["joint_gain"].describe("joint 2", fitted(("gain_2", gain), spread=1e-5), scene)

    values = dict(shown.sentence.values)
    assert (shown.amplitude, shown.unit, shown.standard_uncertainty) == (gain, "1", pytest.approx(1e-5))
    assert values["share"] == pytest.approx(3e-4)
    assert values["way_deg"] == pytest.approx(np.degrees(np.ptp(scene.turn_rad[:, 1])) * 3e-4)
    assert words in english(shown.sentence)
