"""Placing the nominal robot without a guess."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.identification.problem.initial_frames import PriorPlacement, place
from truepose.identification.problem.legs import _Search
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import rotation_xyz

ROTATION, ORIGIN = rotation_xyz(2.8, -1.1, 0.7), np.array([900.0, -2500.0, 340.0])
CENTRES = np.array(NESTS)
FREE = np.ones(3, dtype=bool)
HELD = ~FREE


def readings(joints):
    nest = 1 + np.arange(len(joints)) % 3
    chain = nominal_chain(IRB_120, joints)
    return chain, nest, chain.points(CENTRES[nest - 1]) @ ROTATION.T + ORIGIN


def base_found(placement):
    turn = np.linalg.norm(placement.rotation - ROTATION)
    return turn, np.linalg.norm(placement.origin_mm - ORIGIN)


def test_base_and_certified_nests_place_the_robot_exactly():
    placement = place(*readings(configurations(20)), PriorPlacement(None, CENTRES, HELD))

    # rounding of numbers of some thousand millimetres
    assert base_found(placement) == pytest.approx((0.0, 0.0), abs=1e-8)
    assert np.abs(placement.residual_mm).max() < 1e-8


@pytest.mark.parametrize("share", [0.0, 0.2, 0.35])
def test_gross_readings_do_not_move_base_and_nests(share):
    chain, nest, measured = readings(configurations(60))
    rng = np.random.default_rng(5)
    spoilt = rng.choice(60, int(share * 60), replace=False)
    measured[spoilt] += rng.normal(size=(len(spoilt), 3)) * 200.0

    placement = place(chain, nest, measured, PriorPlacement(None, CENTRES, FREE))

    # theta_6 and the nests turn together: compare places, not nests
    good = np.setdiff1d(np.arange(60), spoilt)
    assert np.linalg.norm(placement.residual_mm[good], axis=1).max() < 0.5
    assert base_found(placement)[1] < 0.5
    assert placement.weights[spoilt].max(initial=0.0) < 0.1 * placement.weights[good].min()


def test_one_unknown_nest_among_certified_ones_is_found():
    unknown = np.array([False, True, False])

    placement = place(
        *readings(configurations(30)), PriorPlacement(None, np.where(unknown[:, None], 0.0, CENTRES), unknown)
    )

    assert placement.nests_mm == pytest.approx(CENTRES, abs=1e-7)


def test_a_known_base_is_held_and_only_nests_are_found():
    placement = place(
        *readings(configurations(30)), PriorPlacement((ROTATION, ORIGIN), np.zeros((3, 3)), FREE)
    )

    assert np.array_equal(placement.origin_mm, ORIGIN)
    assert placement.nests_mm == pytest.approx(CENTRES, abs=1e-7)


def test_a_nest_that_was_never_measured_stays_where_nothing_is_known():
    chain, nest, measured = readings(configurations(30))
    here = nest != 2
    chain = nominal_chain(IRB_120, configurations(30)[here])

    placement = place(chain, nest[here], measured[here], PriorPlacement(None, np.zeros((3, 3)), FREE))

    assert np.abs(placement.residual_mm).max() < 1e-6
    assert np.all(np.isfinite(placement.nests_mm))


def test_motions_of_two_joints_alone_still_place_the_robot():
    """Two parallel axes move in a plane: the base is found as far as the readings tell, without failing."""
    joints = np.tile([0.2, 0.5, -0.3, 0.4, 0.6, 0.1], (25, 1))
    joints[:, 1:3] += np.random.default_rng(3).uniform(-0.5, 0.5, (25, 2))

    placement = place(*readings(joints), PriorPlacement(None, CENTRES, FREE))

    assert np.abs(placement.residual_mm).max() < 1e-4


def test_the_typical_residual_is_blind_to_gross_readings():
    chain, nest, measured = readings(configurations(40))
    measured[:5] += 500.0

    placement = place(chain, nest, measured, PriorPlacement((ROTATION, ORIGIN), CENTRES, HELD))

    assert placement.typical_mm < 1e-8


def test_wherever_the_base_is_turned_to_it_is_found():
    chain, nest, here = readings(configurations(24))
    in_base = (here - ORIGIN) @ ROTATION
    rng = np.random.default_rng(3)

    for turn in Rotation.random(40, rng=rng).as_matrix():
        noise = rng.normal(size=in_base.shape) * 3.0  # a nominal robot's own errors
        placement = place(chain, nest, in_base @ turn.T + ORIGIN + noise, PriorPlacement(None, CENTRES, FREE))

        # 3 mm at the few hundred millimetres that 24 readings spread over; a wrong valley is off by 1 or more
        assert np.linalg.norm(placement.rotation - turn) < 0.03
        assert placement.typical_mm < 6.0


def test_legs_of_known_nests_start_at_their_cups_and_where_a_cup_was_told():
    joints, nests = configurations(24), np.array(NESTS)
    cups = np.array([[600.0, -200.0, 100.0], [700.0, 250.0, 50.0]])
    chain, nest, anchor = nominal_chain(IRB_120, joints), 1 + np.arange(24) % 3, np.arange(24) // 12
    length = np.linalg.norm(chain.points(nests[nest - 1]) - cups[anchor], axis=1)
    told = np.array([[np.nan] * 3, [701.0, 251.0, 51.0]])

    search = _Search(
        chain.rotation[-1], chain.origin[-1], nest, anchor, length, nests, np.zeros(3, bool), told, False
    )
    start = search.start(np.zeros(3)).reshape(2, 3)

    assert start == pytest.approx(np.array([cups[0], told[1]]))
    assert search.residual(cups.ravel()) == pytest.approx(np.zeros(24), abs=1e-9)
    assert search.residual(start.ravel())[:12] == pytest.approx(np.zeros(12), abs=1e-6)
