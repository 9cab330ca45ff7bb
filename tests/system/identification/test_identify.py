"""Identifications whose answer is known: parameters, uncertainties, and what must be said or refused."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import (
    NESTS,
    configurations,
    drawn,
    leg_campaign,
    measured,
    nominal_campaign,
    shifted,
    with_joints,
)
from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError, UnknownEffectError
from truepose.domain.identification import Status
from truepose.domain.robot import FramePlacement, Nest, WorldRegistration
from truepose.identification import identify, predict
from truepose.identification.problem.build import automatic_effects, build
from truepose.kinematics.frames import rotation_xyz
from truepose.messages.catalogue import english


def names_of(answer):
    return [parameter.name for parameter in answer.parameters]


def test_the_irb_120_has_thirty_one_parameters_found_from_its_table():
    campaign, _ = measured(nominal_campaign())

    names = names_of(identify(campaign))

    assert len(names) == 31
    assert sum(name.startswith("base_") for name in names) == 6
    assert sum(name.startswith(("alpha_", "a_", "theta_", "d_")) for name in names) == 19
    assert "d_3" not in names and [name for name in names if name.startswith("beta_")] == ["beta_3"]
    assert [name for name in names if name.startswith("c_")] == ["c_2", "c_3", "c_4", "c_5", "c_6"]


def test_without_noise_the_truth_comes_back():
    campaign, truth = measured(nominal_campaign(), noise_mm=0.0)

    answer = identify(campaign)

    for parameter in answer.parameters:
        # the priors pull by (uncertainty / width)^2 of the value, at most a per cent for c_6
        pull = (
            abs(truth.values[parameter.name]) * (parameter.standard_uncertainty / parameter.prior_width) ** 2
        )
        assert parameter.value == pytest.approx(
            truth.values[parameter.name], abs=0.1 * parameter.standard_uncertainty + 2.0 * pull
        )
    assert answer.calibration.identified.max_mm < 1e-3


def test_gross_readings_are_listed_with_their_size_and_do_not_move_the_model():
    campaign, truth = measured(nominal_campaign(80))
    spoilt = shifted(campaign, [3, 40, 77], np.array([0.4, -0.3, 0.2]))

    answer = identify(spoilt)

    assert [outlier.row for outlier in answer.outliers] == [3, 40, 77]
    assert all("off by" in english(outlier.reason) for outlier in answer.outliers)
    assert answer.counts.outliers == 3
    for parameter in answer.parameters:
        assert abs(parameter.value - truth.values[parameter.name]) < 4.5 * parameter.standard_uncertainty
    assert answer.calibration.identified.max_mm > 0.4 > answer.calibration_without_outliers.identified.max_mm


def test_clean_readings_raise_no_outlier():
    flagged = sum(len(identify(measured(nominal_campaign(60), seed=seed)[0]).outliers) for seed in range(10))

    assert flagged <= 2  # one campaign in a hundred may lose a reading: 10 campaigns, expectation 0.1


def test_a_wrong_nest_label_is_recognised():
    campaign, _ = measured(nominal_campaign())
    points = campaign.calibration
    nest = points.nest.copy()
    nest[10] = 1 + nest[10] % 3
    answer = identify(replace(campaign, calibration=replace(points, nest=nest)))

    assert [outlier.row for outlier in answer.outliers] == [10]
    assert "label is probably wrong" in english(answer.outliers[0].reason)
    assert f"nest {points.nest[10]}" in english(answer.outliers[0].reason)


def test_two_exchanged_rows_are_recognised():
    campaign, _ = measured(nominal_campaign())
    points = campaign.calibration
    order = np.arange(60)
    order[[6, 18]] = order[[18, 6]]  # the same nest
    answer = identify(replace(campaign, calibration=replace(points, position_mm=points.position_mm[order])))

    assert [outlier.row for outlier in answer.outliers] == [6, 18]
    assert "it fits configuration 19" in english(answer.outliers[0].reason)


@pytest.mark.parametrize("base", [FramePlacement(), None], ids=["base known", "base unknown"])
def test_unknown_base_and_tool_are_found_from_anywhere(base):
    rng = np.random.default_rng(8)
    for _ in range(5):
        campaign, _ = measured(nominal_campaign(45))
        rotation, shift = rotation_xyz(*rng.uniform(-3, 3, 3)), rng.uniform(-4000, 4000, 3)
        turned = (
            campaign.calibration.position_mm @ rotation.T + shift
            if base is None
            else campaign.calibration.position_mm
        )
        free = replace(
            campaign,
            base_nominal=base,
            gravity_m_s2=tuple(rotation @ [0, 0, -9.81]) if base is None else (0, 0, -9.81),
            nests=(Nest(None),) * 3,
            calibration=replace(campaign.calibration, position_mm=turned),
        )

        answer = identify(free)

        assert answer.status is Status.CONVERGED
        assert answer.calibration.identified.rms_mm < 0.03  # 0.015 mm per axis
        undetermined = {name for entry in answer.not_identifiable for name in entry.parameters}
        assert {"theta_6", "d_6"} <= undetermined


def test_a_joint_that_never_moved_is_named():
    joints = configurations(80)
    joints[:, 3:5] = 0.4, -0.6
    campaign, _ = measured(nominal_campaign(joints_rad=joints))

    answer = identify(campaign)

    reasons = [english(entry.reason) for entry in answer.not_identifiable]
    assert any("joints 4, 5 never moved" in reason for reason in reasons), reasons


def test_a_spring_on_axis_one_of_a_level_base_is_no_parameter_and_said_so():
    level, _ = measured(nominal_campaign())
    answer = identify(level)

    entry = next(entry for entry in answer.not_identifiable if entry.parameters == ("c_1",))
    assert "never loaded" in english(entry.reason)

    tilted = replace(nominal_campaign(), gravity_m_s2=(4.9, 0.0, -8.5))
    assert "c_1" in names_of(identify(measured(tilted)[0]))


def test_with_unknown_masses_only_products_are_parameters():
    campaign = nominal_campaign(100, robot=replace(IRB_120, masses=()))

    answer = identify(
        measured(campaign, effects=("base", "geometry", "compliance"))[0], ("base", "geometry", "compliance")
    )

    assert "c_2" not in names_of(answer)
    assert any("*" in name for name in names_of(answer))
    assert any("only products" in english(entry.reason) for entry in answer.not_identifiable)


def test_the_scale_needs_a_certified_length():
    effects = ("base", "tool", "geometry", "instrument_scale")
    campaign = replace(
        nominal_campaign(80), nests=(Nest(None),) * 3, tracker_position_mm=(2600.0, -700.0, 500.0)
    )

    answer = identify(measured(campaign, effects=effects)[0], effects)

    assert any(
        "scale" in entry.parameters and "certified length" in english(entry.reason)
        for entry in answer.not_identifiable
    )


def test_d_of_parallel_axes_and_row_one_are_explained():
    answer = identify(measured(nominal_campaign())[0])

    entries = {entry.parameters: english(entry.reason) for entry in answer.not_identifiable}
    assert "axes 2 and 3 are parallel" in entries["d_2", "d_3"]
    assert "base" in entries["d_1", "theta_1", "base_z", "base_rz"]


CHANGES = {
    "joint 4 turns in the opposite direction": lambda q, p: (q * [1, 1, 1, -1, 1, 1], p),
    "zero of joint 3 is off by 90": lambda q, p: (q - np.deg2rad([0, 0, 90, 0, 0, 0]), p),
    "zero of joint 5 is off by -7": lambda q, p: (q + np.deg2rad([0, 0, 0, 0, 7, 0]), p),
    "radians": lambda q, p: (np.deg2rad(q), p),
    "metres": lambda q, p: (q, p / 1e3),
    "left-handed": lambda q, p: (q, p * [1, 1, -1]),
    "coupled to joint 2": lambda q, p: (q + np.outer(q[:, 1], [0, 0, 1, 0, 0, 0]), p),
    "joints 4 and 5 are swapped": lambda q, p: (q[:, [0, 1, 2, 4, 3, 5]], p),
}


@pytest.mark.parametrize("base", [FramePlacement(), None], ids=["base known", "base unknown"])
@pytest.mark.parametrize("words", CHANGES)
def test_a_wrong_convention_is_named(words, base):
    campaign, _ = measured(nominal_campaign())
    points = campaign.calibration
    joints, position = CHANGES[words](points.stops.joints_rad, points.position_mm)
    wrong = with_joints(
        replace(campaign, base_nominal=base, calibration=replace(points, position_mm=position)), joints
    )

    answer = identify(wrong)

    assert answer.status is Status.WRONG_NOMINAL_MODEL
    assert words in english(answer.message)


def test_another_robot_is_said_to_be_one():
    campaign, _ = measured(nominal_campaign())
    longer = replace(IRB_120.joints[2], a_mm=340.0)
    robot = replace(IRB_120, joints=(*IRB_120.joints[:2], longer, *IRB_120.joints[3:]))

    answer = identify(replace(campaign, robot=robot))

    assert answer.status is Status.WRONG_NOMINAL_MODEL
    assert "check that the kinematic table is that of the measured robot" in english(answer.message)


def test_a_right_robot_is_never_called_a_wrong_one():
    for seed in range(5):
        campaign = nominal_campaign(60, seed=seed)
        values = drawn(build(campaign, automatic_effects(campaign)), seed, share=1.0)
        assert identify(measured(campaign, values, seed=seed)[0]).status is Status.CONVERGED


def test_many_gross_readings_are_not_fitted():
    campaign, _ = measured(nominal_campaign(60))
    rng = np.random.default_rng(9)

    answer = identify(shifted(campaign, np.arange(0, 60, 3), rng.normal(size=(20, 3)) * 20.0))

    assert answer.status is Status.OUTLIERS_DOMINATE
    assert "20 of 60" in english(answer.message)


@pytest.mark.parametrize(
    ("rows", "words"), [([0, 1, 2], "3 different configurations"), ([0] * 30, "one configuration")]
)
def test_too_few_data_say_how_many_are_needed(rows, words):
    campaign, _ = measured(nominal_campaign())
    points = campaign.calibration
    few = replace(
        points,
        stops=points.stops.taken(np.array(rows)),
        nest=points.nest[rows],
        position_mm=points.position_mm[rows],
        standard_uncertainty_mm=points.standard_uncertainty_mm[rows],
    )

    answer = identify(replace(campaign, calibration=few))

    assert answer.status is Status.TOO_FEW_DATA
    assert words in english(answer.message) and answer.model is None


def test_nest_labels_exchanged_throughout_are_a_convention_not_gross_readings():
    campaign, _ = measured(nominal_campaign())
    points = campaign.calibration
    exchanged = np.choose(points.nest - 1, [1, 3, 2])

    answer = identify(replace(campaign, calibration=replace(points, nest=exchanged)))

    assert answer.status is Status.WRONG_NOMINAL_MODEL
    assert "nests 2 and 3 are swapped throughout" in english(answer.message)


def test_an_instrument_that_does_not_follow_is_no_measurement():
    campaign, _ = measured(nominal_campaign())
    stuck = np.broadcast_to(campaign.calibration.position_mm[0], (60, 3))

    answer = identify(replace(campaign, calibration=replace(campaign.calibration, position_mm=stuck)))

    assert answer.status is Status.TOO_FEW_DATA
    assert "did not follow the robot" in english(answer.message)


def test_a_base_far_from_its_nominal_place_is_found_and_said():
    campaign, _ = measured(nominal_campaign())
    quarter = rotation_xyz(0.0, 0.0, np.pi / 2)
    moved = campaign.calibration.position_mm @ quarter.T + [1000.0, 0.0, 0.0]

    answer = identify(replace(campaign, calibration=replace(campaign.calibration, position_mm=moved)))

    assert answer.status is Status.CONVERGED
    assert "the base is 1000 mm and 90." in english(answer.message)
    assert answer.calibration.identified.rms_mm < 0.03  # 0.015 mm per axis
    assert "base stands" not in english(identify(campaign).message)


def test_a_noisy_instrument_is_not_called_gross_readings():
    campaign, _ = measured(nominal_campaign(), noise_mm=5.0)

    answer = identify(campaign)

    assert answer.status is not Status.OUTLIERS_DOMINATE
    assert answer.outliers == ()


def test_a_wire_from_an_unknown_anchor_is_placed_without_a_guess():
    answer = identify(leg_campaign(300, offset_mm=7.0))

    assert answer.status is Status.CONVERGED
    assert answer.quantity == "length"
    assert answer.calibration.identified.rms_mm < 0.006  # noise 0.005 mm


def test_readings_of_one_stop_share_the_scatter_of_the_arm():
    joints = np.repeat(configurations(25), 3, axis=0)
    campaign, _ = measured(nominal_campaign(joints_rad=joints))
    points = campaign.calibration
    config = np.repeat(np.arange(25), 3)
    one = replace(points, stops=replace(points.stops, config=config))
    scattered = replace(campaign, calibration=one, robot=replace(IRB_120, repeatability_mm=0.2))
    alone = replace(scattered, calibration=replace(points, stops=replace(points.stops, config=np.arange(75))))

    together = {p.name: p.standard_uncertainty for p in identify(scattered).parameters}
    apart = {p.name: p.standard_uncertainty for p in identify(alone).parameters}

    # where three nests differ says how the tool is turned, whatever the arm's scatter: theta_6 gains;
    # the place of the base is known less well, as from 25 stops instead of 75
    assert together["theta_6"] < 0.3 * apart["theta_6"]
    assert together["base_x"] > 1.2 * apart["base_x"]


def test_certified_nests_and_the_registration_widen_the_base_only_by_what_they_say():
    campaign, _ = measured(nominal_campaign(50))
    exact = replace(
        campaign, nests=tuple(replace(nest, standard_uncertainty_mm=None) for nest in campaign.nests)
    )
    covariance = np.diag([0.01**2] * 3 + [1e-12] * 3)

    plain = {p.name: p.standard_uncertainty for p in identify(exact).parameters}
    moved = identify(replace(exact, registration=WorldRegistration(covariance)))
    wide = {p.name: p.standard_uncertainty for p in moved.parameters}

    assert wide["base_x"] ** 2 - plain["base_x"] ** 2 == pytest.approx(0.01**2, rel=0.02)
    assert wide["a_3"] == pytest.approx(plain["a_3"], rel=1e-3)


def test_cross_validation_stands_in_where_there_is_no_validation_file():
    campaign, _ = measured(nominal_campaign(50))

    answer = identify(campaign)

    assert answer.validation is None
    # a held-out reading has its noise and that of the model: more than in the calibration
    assert answer.cross_validation.identified.rms_mm > answer.calibration.identified.rms_mm
    assert answer.cross_validation.identified.rms_mm < 2.0 * answer.calibration.identified.rms_mm


def test_revisits_give_pure_error():
    joints = configurations(60)
    joints[50:] = joints[:10]
    campaign, _ = measured(nominal_campaign(joints_rad=joints))
    points = campaign.calibration
    nest = points.nest.copy()
    nest[50:] = nest[:10]
    repeat_of = np.r_[np.full(50, -1), np.arange(1, 11)]
    stops = replace(points.stops, repeat_of=repeat_of)
    again = replace(campaign, calibration=replace(points, stops=stops, nest=nest))
    again, _ = measured(again)

    found = identify(again).pure_error

    assert found.revisits == 10
    assert found.repeatability_mm == pytest.approx(0.015, rel=0.5)  # 30 degrees of freedom: 13 % at one sigma
    assert found.p_value > 1e-3


def test_predictions_carry_an_uncertainty_that_held_out_errors_agree_with():
    campaign, truth = measured(nominal_campaign(50))
    model = identify(campaign).model
    fresh = nominal_campaign(300, seed=77)
    exact, _ = measured(fresh, np.array(list(truth.values.values())), noise_mm=0.0)

    position, u = predict(model, exact.calibration.stops, exact.calibration.nest)

    error = np.sqrt(np.mean((position - exact.calibration.position_mm) ** 2))
    assert np.sqrt(np.mean(u**2)) == pytest.approx(error, rel=0.6)  # one campaign's errors are correlated


def test_unknown_effects_and_twice_the_same_parameter_are_refused():
    campaign = nominal_campaign()
    with pytest.raises(UnknownEffectError, match="available effects: base"):
        identify(campaign, ("base", "magic"))
    with pytest.raises(ConfigurationError, match="Leave out one of the two effects"):
        identify(campaign, ("base", "geometry", "joint_offset"))
    with pytest.raises(ConfigurationError, match="no calibration points, ballbar lengths or contacts"):
        identify(Campaign(IRB_120, None, (Nest(NESTS[0]),)))
