"""What is known of lengths before anything is measured moves as the arm, its cups and its nests do."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell
from tests.helpers.ballbar.early_sessions import plan_of
from tests.helpers.ballbar.true_session import TrueArm
from truepose.domain.cell import BallbarKit
from truepose.domain.robot import FramePlacement
from truepose.planning.ballbar.length_forecast import SessionForecast, forecast_lengths


@pytest.fixture(scope="module")
def plan():
    return plan_of(ballbar_cell(), poses=3)


def spread_mm(beforehand, kind, stop):
    covariance = stop.slope @ kind.covariance @ stop.slope.T
    return np.sqrt(np.diag(covariance))


def test_lengths_move_as_an_arm_with_other_links_moves_nests_and_cups(plan):
    cell = ballbar_cell()
    beforehand = SessionForecast(cell, plan, BallbarKit())
    placement = plan.placements[0]
    joints = np.array([pose.joints_rad for pose in placement.poses])
    stops = beforehand.poses(1, joints)
    true, nominal = (TrueArm.drawn(cell, 5, size, 200.0 * size) for size in (1e-4, 0.0))

    for pose, stop in zip(placement.poses, stops, strict=True):
        moved = [
            true.length(placement, pose.joints_rad, pair) - nominal.length(placement, pose.joints_rad, pair)
            for pair in stop.pairs
        ]
        # What arms can do to nine lengths is a space of few dimensions; this arm's doing lies in it.
        left = np.array(moved) - stop.slope @ np.linalg.lstsq(stop.slope, moved, rcond=None)[0]
        assert np.abs(left).max() < 1e-4
        assert stop.nominal_mm == pytest.approx(
            [nominal.length(placement, pose.joints_rad, pair) for pair in stop.pairs], abs=1e-6
        )


def test_real_sizes_of_errors_are_foreseen_within_their_spread(plan):
    cell = ballbar_cell()
    beforehand = SessionForecast(cell, plan, BallbarKit())
    placement = plan.placements[0]
    pose = placement.poses[0]
    stop = beforehand.poses(1, np.array([pose.joints_rad]))[0]
    spread = spread_mm(beforehand, beforehand.kinds()[0], stop)

    nominal = TrueArm.drawn(cell, 0, 0.0, 0.0)
    off = [
        TrueArm.drawn(cell, seed, 1e-3, 0.2).length(placement, pose.joints_rad, pair)
        - nominal.length(placement, pose.joints_rad, pair)
        for seed in range(40)
        for pair in pose.legs
    ]

    own = [spread[stop.pairs.index(pair)] for pair in pose.legs]
    # TrueArm errs in every link parameter, ours in all but those that act as another one: about alike.
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(np.sqrt(np.mean(np.square(own))), rel=0.35)


def test_where_the_base_stands_plays_no_part(plan):
    cell = ballbar_cell()
    joints = np.array([plan.placements[0].poses[0].joints_rad])
    stops = [
        SessionForecast(replace(cell, base=base), plan, BallbarKit()).poses(1, joints)[0]
        for base in (FramePlacement(), FramePlacement(100.0, -50.0, 3.0, 0.1, 0.2, 0.3))
    ]

    assert stops[1].nominal_mm == pytest.approx(stops[0].nominal_mm, abs=1e-6)


def test_the_kinds_of_arms_are_all_arms(plan):
    kinds = SessionForecast(ballbar_cell(), plan, BallbarKit()).kinds()

    assert [kind.share for kind in kinds] == pytest.approx([0.36, 0.36, 0.18, 0.04, 0.04, 0.02])
    for kind, link, nest_mm in zip(kinds, (0.2,) * 3 + (0.6,) * 3, (0.0, 0.02, 0.04) * 2, strict=True):
        # In widths of their priors, lengths and angles and then the springs of joints 2 to 6; nests in mm.
        spread = np.sqrt(np.diag(kind.covariance))
        assert kind.mean[:25].tolist() == [0.0] * 20 + [1.0] * 5
        assert spread[:25] == pytest.approx(np.array([link] * 20 + [1.0] * 5))
        assert spread[25:34] == pytest.approx(np.full(9, np.hypot(0.002, nest_mm)))


def test_cups_are_known_from_each_other_as_well_as_the_ballbar_measures_their_sides(plan):
    beforehand = SessionForecast(ballbar_cell(), plan, BallbarKit())
    sides = beforehand.sides(1)

    assert sides.pairs == ((1, 2), (1, 3), (2, 3))
    assert sides.nominal_mm == pytest.approx([300.0] * 3, abs=0.01)
    assert (spread_mm(beforehand, beforehand.kinds()[0], sides) > 0.1).all()
    assert not sides.motion.any()


def test_a_plan_for_another_arm_or_without_set_ups_says_nothing_of_lengths(plan):
    (placement,) = plan.placements
    kit = BallbarKit()
    turned = tuple(
        replace(pose, joints_rad=(*pose.joints_rad[:5], pose.joints_rad[5] + 0.1)) for pose in placement.poses
    )
    for other in (
        replace(placement, poses=turned),
        replace(placement, setups=placement.setups[:2]),
        replace(placement, poses=(replace(placement.poses[0], legs=((4, 1),)),)),
    ):
        assert forecast_lengths(domain_cell(), replace(plan, placements=(other,)), kit) is None
    assert forecast_lengths(domain_cell(), replace(plan, placements=()), kit) is None
    assert forecast_lengths(domain_cell(), plan, kit) is not None


def test_a_tool_with_unknown_nests_says_nothing_of_lengths(plan):
    assert forecast_lengths(replace(domain_cell(), nests=()), plan, BallbarKit()) is None


def test_a_plan_whose_cups_are_all_at_one_place_says_nothing_of_lengths(plan):
    (placement,) = plan.placements
    held = placement.setups[0].joints_rad
    same = tuple(replace(setup, joints_rad=held) for setup in placement.setups)
    at_the_cup = tuple(replace(pose, joints_rad=held) for pose in placement.poses)
    other = replace(placement, setups=same, poses=at_the_cup)

    assert forecast_lengths(domain_cell(), replace(plan, placements=(other,)), BallbarKit()) is None
