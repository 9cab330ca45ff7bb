"""Every analytic derivative of every effect against central differences, at a point away from zero."""

from dataclasses import fields, replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.differences import require_alike
from tests.helpers.identification.synthetic import leg_campaign, nominal_campaign
from truepose.domain.campaign import LegReadings
from truepose.domain.robot import Nest
from truepose.identification.model.evaluation import evaluate
from truepose.identification.observations.poses import OrientationBlock, PositionBlock
from truepose.identification.problem.build import automatic_effects, build
from truepose.kinematics.frames import rotation_xyz
from truepose.kinematics.gravity import gravity_torques

JOINTS_7 = np.random.default_rng(7).uniform(-1.5, 1.5, (12, 7))


def held_torques(problem, values):
    """The problem with the torques in force written into its rows, as the derivative holds them."""
    block = problem.blocks[0]
    state = evaluate(problem.structure, values, block.targets)
    stops = replace(block.targets.stops, torque_n_mm=state.torque_n_mm)
    held = replace(block, targets=replace(block.targets, stops=stops))
    return replace(problem, structure=replace(problem.structure, torques_measured=True), blocks=(held,))


def displaced(problem, seed=3):
    rng = np.random.default_rng(seed)
    return problem.start + 0.3 * problem.structure.prior_widths * rng.standard_normal(len(problem.start))


@pytest.mark.parametrize(
    "effects",
    [
        ("base", "geometry", "compliance"),
        ("base", "geometry_dhm", "joint_gain"),
        ("base", "joint_offset", "joint_gain"),
        ("base", "geometry", "instrument_scale"),
        ("base", "tool", "geometry", "compliance", "joint_gain", "instrument_scale"),
    ],
    ids="+".join,
)
def test_positions_of_the_irb_120(effects):
    campaign = nominal_campaign(12, tracker_position_mm=(2600.0, -700.0, 500.0))
    problem = build(campaign, effects)
    values = displaced(problem)
    held = held_torques(problem, values) if "compliance" in effects else problem

    require_alike(held.structure, held.blocks, values)


def test_positions_with_unknown_base_and_nests_of_a_robot_with_signs():
    campaign = nominal_campaign(
        robot=SEVEN_AXES, joints_rad=JOINTS_7, base=None, nests=((0.0, 10.0, 80.0), (40.0, -5.0, 90.0))
    )
    campaign = replace(campaign, nests=(Nest(None), Nest(None)))
    problem = build(campaign, automatic_effects(campaign))

    require_alike(problem.structure, problem.blocks, displaced(problem))


def test_a_joint_with_a_gain_turns_further_the_way_it_turns_whatever_its_sign():
    campaign = nominal_campaign(robot=SEVEN_AXES, joints_rad=JOINTS_7, nests=((0.0, 10.0, 80.0),))
    problem = build(campaign, ("base", "joint_gain"))
    values = np.zeros(len(problem.start))
    values[problem.structure.index_of("gain_2")] = 1e-3  # joint 2 has sign -1

    gained = evaluate(problem.structure, values, problem.blocks[0].targets).position_mm

    further = JOINTS_7 * (1.0 + 1e-3 * (np.arange(7) == 1))
    turned = nominal_campaign(robot=SEVEN_AXES, joints_rad=further, nests=((0.0, 10.0, 80.0),))
    assert gained == pytest.approx(turned.calibration.position_mm, abs=1e-9)


def test_products_of_compliance_and_unknown_moments():
    campaign = nominal_campaign(12, robot=replace(IRB_120, masses=()))
    problem = build(campaign, ("base", "geometry", "compliance"))

    # The regressors are those of the chain one pass before: their change with the chain is left out,
    # and amounts to the deflection (5 mrad) itself.
    require_alike(problem.structure, problem.blocks, 0.1 * displaced(problem), rel=5e-3)


def test_that_a_torque_follows_the_deflection_is_left_out_and_is_small():
    problem = build(nominal_campaign(12), ("base", "geometry", "compliance"))

    # a_4: 7.7 kg * 9.81 m/s2 * 6e-7 rad/(N mm) * 300 mm is 0.014 of what the length itself moves
    require_alike(problem.structure, problem.blocks, displaced(problem), rel=0.02)


@pytest.mark.parametrize("soft", [1.0, 10.0])  # ten times what is usual still converges
def test_the_torques_in_force_are_those_at_the_deflected_arm(soft):
    problem = build(nominal_campaign(12), ("base", "geometry", "compliance"))
    springs = [name.startswith("c_") for name in problem.structure.names]
    values = displaced(problem) + np.where(springs, (soft - 1.0) * problem.structure.prior_means, 0.0)
    targets = problem.blocks[0].targets

    cold = evaluate(problem.structure, values, targets)
    near = evaluate(problem.structure, values + 1e-6 * displaced(problem), targets)
    warm = evaluate(problem.structure, values, targets, near)

    for state in (cold, warm):
        balanced = gravity_torques(state.chain, IRB_120.masses, problem.structure.gravity_m_s2)
        # documented: 1e-5 of the largest torque
        assert state.torque_n_mm == pytest.approx(balanced, abs=1e-5 * np.abs(balanced).max())
    assert warm.position_mm == pytest.approx(cold.position_mm, abs=1e-4)


def test_who_asks_for_residuals_alone_has_nothing_differentiated():
    class Undifferentiated(PositionBlock):
        def derivatives(self, state):
            raise AssertionError

    campaign = nominal_campaign(12)
    problem = build(campaign, ("base", "geometry"))
    points = problem.blocks[0]
    block = Undifferentiated(**{field.name: getattr(points, field.name) for field in fields(points)})

    assert np.isfinite(block.result(problem.structure, problem.start, None).residual).all()
    with pytest.raises(AssertionError):
        _ = block.result(problem.structure, problem.start, None).jacobian


def test_orientations():
    campaign = nominal_campaign(12)
    problem = build(
        replace(campaign, nests=(Nest(None), Nest(None), Nest(None))), ("base", "tool", "geometry")
    )
    state = evaluate(problem.structure, problem.start, problem.blocks[0].targets)
    turned = state.orientation @ rotation_xyz(0.02, -0.01, 0.03)
    block = OrientationBlock(
        targets=problem.blocks[0].targets, measured=turned, uncertainty=np.full(12, 1e-3), weights=np.ones(12)
    )

    require_alike(problem.structure, (block,), displaced(problem))


def test_legs_with_anchor_attachment_and_offset():
    problem = build(leg_campaign(30), ("tool", "geometry"))

    require_alike(problem.structure, problem.blocks, displaced(problem))


def test_legs_that_share_a_stop_are_whitened_together():
    campaign = leg_campaign(4)
    legs = campaign.legs
    twice = np.repeat(np.arange(4), 2)
    stops = replace(legs.stops, config=legs.stops.config[twice], joints_rad=legs.stops.joints_rad[twice])
    pair = LegReadings(
        stops, legs.placement[twice], 1 + np.arange(8) % 2, legs.nest[twice],
        legs.length_mm[twice], legs.standard_uncertainty_mm[twice],
    )  # fmt: skip
    robot = replace(campaign.robot, repeatability_mm=0.05)
    problem = build(replace(campaign, legs=pair, robot=robot), ("tool", "joint_offset"))
    result = problem.blocks[0].result(problem.structure, problem.start, None)

    white = result.whitening.apply(np.eye(8)[:, :, None])[:, :, 0]

    direction = result.direction
    expected = 0.005**2 * np.eye(8) + 0.05**2 * direction @ direction.T * (twice[:, None] == twice[None, :])
    assert np.linalg.inv(white @ white.T) == pytest.approx(expected, rel=1e-6, abs=1e-12)
