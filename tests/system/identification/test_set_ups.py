"""Set-ups off the beaten track: robots on walls, few joints, nests half known, poses, legs with a base."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import (
    NESTS,
    configurations,
    leg_campaign,
    measured,
    nominal_campaign,
)
from truepose.domain.campaign import LegReadings
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Status
from truepose.domain.robot import FramePlacement, Nest, Robot
from truepose.exchange.models.file import model_from_text, model_text
from truepose.identification import identify, judge, predict
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import automatic_effects, build
from truepose.identification.problem.problem_setup import setting_of
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation, rotation_xyz

WALL = FramePlacement(500.0, -200.0, 1500.0, 0.0, np.pi / 2, 0.0)
NOISE_RMS_MM = 0.015 * np.sqrt(3.0)


def names_of(answer):
    return {parameter.name for parameter in answer.parameters}


def open_names(answer):
    return {name for entry in answer.not_identifiable for name in entry.parameters}


def assert_explains_the_noise(answer):
    assert answer.status is Status.CONVERGED, answer.message
    assert answer.calibration.identified.rms_mm < 1.15 * NOISE_RMS_MM
    # 95 % limits of 100 degrees of freedom and more
    assert answer.chi2_per_dof == pytest.approx(1.0, abs=0.35)
    assert answer.outliers == ()


def moved(campaign, base):
    """The campaign of a robot that stands elsewhere, world and gravity unchanged."""
    points = campaign.calibration
    rotation = placement_rotation(base)
    return replace(
        campaign,
        base_nominal=base,
        calibration=replace(
            points, position_mm=points.position_mm @ rotation.T + placement_translation(base)
        ),
    )


@pytest.mark.parametrize("ry_deg", [90.0, -90.0, 90.0 - 1e-4, 89.0])
@pytest.mark.parametrize("known", [True, False], ids=["base known", "base unknown"])
def test_a_robot_on_a_wall_is_identified_and_its_model_survives_a_file(ry_deg, known):
    base = replace(WALL, rx_rad=0.3, ry_rad=np.deg2rad(ry_deg), rz_rad=-0.2)
    campaign, _ = measured(moved(nominal_campaign(60), base))
    campaign = campaign if known else replace(campaign, base_nominal=None)

    answer = identify(campaign)

    assert_explains_the_noise(answer)
    assert "c_1" in names_of(answer)  # axis 1 is level: its spring carries the arm
    again = model_from_text(model_text(answer.model).encode(), "model.json")
    points = campaign.calibration
    there, _ = predict(again, points.stops, points.nest)
    here, _ = predict(answer.model, points.stops, points.nest)
    assert there == pytest.approx(here, abs=1e-6)
    assert np.sqrt(np.mean(np.sum((here - points.position_mm) ** 2, axis=1))) < 1.15 * NOISE_RMS_MM


def test_where_the_base_is_unknown_gravity_is_taken_as_the_base_was_found():
    """Upright in a world whose z axis is level: axis 1 carries nothing, whatever the world's axes say."""
    turned = rotation_xyz(0.0, np.pi / 2, 0.4)
    campaign, _ = measured(nominal_campaign(60))
    points = campaign.calibration
    free = replace(
        campaign,
        base_nominal=None,
        gravity_m_s2=tuple(turned @ [0.0, 0.0, -9.81]),
        calibration=replace(points, position_mm=points.position_mm @ turned.T),
    )

    answer = identify(free)

    assert_explains_the_noise(answer)
    assert "c_1" not in names_of(answer)
    assert setting_of(free, points.stops, turned).largest_torque_n_mm[0] < 1e-6


@pytest.mark.parametrize("n_joints", [1, 2, 3, 4, 5])
def test_robots_of_few_joints_are_identified(n_joints):
    robot = Robot("short", IRB_120.joints[:n_joints], repeatability_mm=0.003)
    joints = configurations(90)[:, :n_joints]

    campaign, _ = measured(nominal_campaign(robot=robot, joints_rad=joints))
    answer = identify(campaign)

    assert_explains_the_noise(answer)
    fresh = nominal_campaign(robot=robot, joints_rad=configurations(20, seed=5)[:, :n_joints])
    position, u = predict(answer.model, fresh.calibration.stops, fresh.calibration.nest)
    assert np.all(np.isfinite(position)) and np.all(u < 0.1)


def test_nests_of_which_some_are_unknown_are_found_beside_the_certified_ones():
    campaign, _ = measured(nominal_campaign(60))
    half = replace(campaign, nests=(campaign.nests[0], Nest(None), campaign.nests[2]))

    answer = identify(half)

    assert_explains_the_noise(answer)
    assert {name for name in names_of(answer) if name.startswith("nest_")} == {
        "nest_2_x", "nest_2_y", "nest_2_z",
    }  # fmt: skip
    start = {nest.nest: nest.centre_mm for nest in answer.model.nests}
    found = [p.value for p in answer.parameters if p.name.startswith("nest_2")]
    # the certified nests fix the frame of the tool
    assert np.add(start[2], found) == pytest.approx(NESTS[1], abs=0.15)


def test_an_unknown_nest_that_was_never_measured_is_named():
    campaign, _ = measured(nominal_campaign(60))

    answer = identify(replace(campaign, nests=(*campaign.nests, Nest(None))))

    assert_explains_the_noise(answer)
    assert {"nest_4_x", "nest_4_y", "nest_4_z"} <= open_names(answer)
    _, u = predict(answer.model, campaign.calibration.stops, np.full(60, 4))
    assert u.min() > 5.0  # the prior of 10 mm per axis is all that is known


def test_certified_nests_of_which_some_were_never_measured_do_not_matter():
    campaign, _ = measured(nominal_campaign(60))
    spare = Nest((0.0, -90.0, 130.0), 0.002)

    assert names_of(identify(replace(campaign, nests=(*campaign.nests, spare)))) == names_of(
        identify(campaign)
    )


@pytest.mark.parametrize("tool", [(0.0, 0.0, 0.0), (0.3, np.pi / 2, -0.4), (3.0, 0.1, 2.0)])
def test_poses_place_an_unknown_base_and_an_unknown_tool(tool):
    base = FramePlacement(-900.0, 2500.0, 300.0, 2.5, -0.4, 1.0)
    plain = moved(nominal_campaign(60), base)
    campaign, truth = measured(plain)
    problem = build(plain, automatic_effects(plain))
    points = campaign.calibration
    values = np.array(list(truth.values.values()))
    state = evaluate(problem.structure, values, Targets(points.stops, points.nest))
    rng = np.random.default_rng(6)
    noise = Rotation.from_rotvec(1e-4 * rng.standard_normal((60, 3))).as_matrix()
    seen = noise @ state.orientation @ rotation_xyz(*tool)
    poses = replace(points, quaternion=Rotation.from_matrix(seen).as_quat()[:, [3, 0, 1, 2]])
    free = replace(campaign, base_nominal=None, nests=(Nest(None),) * 3, calibration=poses)

    answer = identify(free)

    assert_explains_the_noise(answer)
    assert {"tool_rx", "tool_ry", "tool_rz"} <= names_of(answer)
    # seen as orientations, the tool's rotation and the zero of joint 6 are one
    assert "theta_6" in open_names(answer)


def test_an_effect_that_leaves_open_what_the_campaign_does_not_know_is_refused():
    campaign = nominal_campaign(40)
    with pytest.raises(ConfigurationError, match=r"does not give the base position\. Add `base`"):
        identify(replace(campaign, base_nominal=None), ("geometry",))
    with pytest.raises(ConfigurationError, match=r"does not give the position of nest 2\. Add `tool`"):
        identify(replace(campaign, nests=(Nest(NESTS[0]), Nest(None), Nest(NESTS[2]))), ("base", "geometry"))


def test_effects_that_find_nothing_unknown_are_refused():
    with pytest.raises(ConfigurationError, match="The campaign leaves no parameters of tool unknown"):
        identify(nominal_campaign(40), ("tool",))


def test_a_base_that_is_held_stays_where_the_drawing_puts_it():
    effects = ("geometry", "compliance")
    campaign, truth = measured(nominal_campaign(60), effects=effects)

    answer = identify(campaign, effects)

    assert_explains_the_noise(answer)
    assert answer.model.base == answer.model.nominal_base == campaign.base_nominal
    assert names_of(answer) == set(truth.values)


def test_revisits_of_a_single_place_cannot_be_cross_validated():
    campaign, _ = measured(nominal_campaign(60))
    points = campaign.calibration
    stops = replace(points.stops, repeat_of=np.ones(60, dtype=np.int64))

    answer = identify(replace(campaign, calibration=replace(points, stops=stops)))

    assert answer.cross_validation is None
    assert answer.counts.configurations == 1


def test_readings_without_any_noise_and_of_absurd_precision_are_identified():
    campaign, _ = measured(nominal_campaign(60), noise_mm=0.0)
    points = campaign.calibration
    robot = replace(IRB_120, repeatability_mm=0.0)
    precise = replace(points, standard_uncertainty_mm=np.full(60, 1e-9))
    free = replace(campaign, robot=robot, calibration=precise, nests=(Nest(None),) * 3)

    answer = identify(free)

    assert answer.status in {Status.CONVERGED, Status.NOT_CONVERGED}
    assert answer.calibration.identified.max_mm < 1e-2
    assert {"theta_6", "d_6"} <= open_names(answer)


def test_a_torque_that_is_missing_somewhere_is_asked_for():
    campaign = nominal_campaign(40)
    points = campaign.calibration
    torque = np.full((40, 6), 100.0)
    torque[7, 2] = np.nan
    gaps = replace(campaign, calibration=replace(points, stops=replace(points.stops, torque_n_mm=torque)))

    with pytest.raises(ConfigurationError, match="Configuration 8 lacks a measured joint torque"):
        identify(gaps)
    assert identify(gaps, ("base", "geometry")).status is Status.CONVERGED


def test_columns_of_unknown_values_change_nothing():
    campaign, _ = measured(nominal_campaign(50))
    points = campaign.calibration
    unknown = np.full(50, np.nan)
    stops = replace(
        points.stops,
        time_s=unknown,
        temperature_c=unknown,
        torque_n_mm=np.full((50, 6), np.nan),
        direction=np.zeros((50, 6), dtype=np.int64),
        attachment=np.arange(50) // 10,
    )

    plain = identify(campaign)
    silent = identify(replace(campaign, calibration=replace(points, stops=stops)))

    assert [p.value for p in silent.parameters] == [p.value for p in plain.parameters]


@pytest.mark.parametrize("base", [WALL, FramePlacement(800.0, 100.0, -300.0, 0.1, -0.2, 2.0)])
def test_legs_of_a_robot_whose_base_is_known_are_placed_in_the_world(base):
    campaign = leg_campaign(250)

    here, there = identify(campaign), identify(replace(campaign, base_nominal=base))

    assert there.status is Status.CONVERGED
    assert there.calibration.identified.rms_mm == pytest.approx(here.calibration.identified.rms_mm, rel=1e-3)
    residuals = [judge(answer.model, campaign.legs, 0.0).identified_mm for answer in (there, here)]
    assert residuals[0] == pytest.approx(residuals[1], abs=1e-3)
    anchor = np.array([250.0, -450.0, -80.0])
    placed = placement_rotation(base) @ anchor + placement_translation(base)
    found = [p.value for p in there.parameters if p.name.startswith("anchor_1_1")]
    # geometry and anchor are seen together to some tenths of a millimetre
    assert found == pytest.approx(placed, abs=3.0)


def test_legs_to_several_anchors_and_nests_have_anchors_of_their_own():
    joints = configurations(240)
    nests = np.array(NESTS)
    places = np.array([[400.0, -400.0, -60.0], [500.0, 300.0, 0.0], [-300.0, 450.0, -30.0]])
    nest, point = 1 + np.arange(240) % 3, 1 + (np.arange(240) // 3) % 3
    ends = nominal_chain(IRB_120, joints).points(nests[nest - 1])
    length = np.linalg.norm(ends - places[point - 1], axis=1)
    length += 0.005 * np.random.default_rng(4).standard_normal(240)
    wire = leg_campaign(240)
    legs = LegReadings(wire.legs.stops, np.ones(240, dtype=int), point, nest, length, np.full(240, 0.005))
    campaign = replace(
        wire, nests=tuple(Nest(centre, 0.002) for centre in NESTS), legs=legs, ballbar_nominal_mm=600.0
    )

    answer = identify(replace(campaign, legs=replace(legs, stops=replace(legs.stops, joints_rad=joints))))

    assert answer.status is Status.CONVERGED
    # two thirds of 240 readings are free; the arm's own scatter of 0.0035 mm was not drawn
    assert answer.calibration.identified.rms_mm == pytest.approx(0.005, rel=0.2)
    assert {f"anchor_1_{k}_{axis}" for k in (1, 2, 3) for axis in "xyz"} <= names_of(answer)
    assert "length_offset" not in names_of(answer)


def test_cross_validation_leaves_out_a_place_with_all_its_revisits():
    """What the model lacks at a place is the same at its revisit: left in, one would hide it in the other."""
    effects, rng = ("base", "geometry"), np.random.default_rng(2)
    twice = np.vstack([configurations(16)] * 2)
    lacking = np.tile(0.3 * rng.standard_normal((16, 3)), (2, 1))
    campaign = nominal_campaign(joints_rad=twice)
    points = campaign.calibration
    noise = 0.015 * rng.standard_normal((32, 3))
    nest = np.tile(1 + np.arange(16) % 3, 2)
    places = nominal_chain(IRB_120, twice).points(np.array(NESTS)[nest - 1]) + lacking + noise
    visited = replace(campaign, calibration=replace(points, nest=nest, position_mm=places))
    repeat_of = np.r_[np.full(16, -1), np.arange(1, 17)]
    stops = replace(points.stops, repeat_of=repeat_of)
    told = replace(visited, calibration=replace(visited.calibration, stops=stops))

    blind, seeing = identify(visited, effects), identify(told, effects)

    assert seeing.counts.configurations == 16 and blind.counts.configurations == 32
    # 26 parameters absorb half of what 16 places show; a place left out with its twin shows it all
    assert seeing.cross_validation.identified.rms_mm > 1.25 * blind.cross_validation.identified.rms_mm
