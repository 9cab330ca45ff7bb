"""Which of several robots readings are of, as they are or with one or two changes of convention."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.identification.problem.initial_frames import PriorPlacement
from truepose.identification.verdict.conventions import Evidence, plausible_mm
from truepose.identification.verdict.robot_match import match, matches
from truepose.kinematics.chain import nominal_chain

KNOWN = PriorPlacement(None, np.array(NESTS), np.zeros(3, dtype=bool))
JOINTS = configurations(20)
NEST = 1 + np.arange(20) % 3
SEEN = Evidence(JOINTS, NEST, nominal_chain(IRB_120, JOINTS).points(np.array(NESTS)[NEST - 1]))
LONGER = replace(
    IRB_120, joints=(*IRB_120.joints[:2], replace(IRB_120.joints[2], a_mm=400.0), *IRB_120.joints[3:])
)


def kinds(found):
    return [change.kind for change in found.changes]


def test_the_robot_itself_fits_as_it_is():
    found = match(IRB_120, SEEN, KNOWN)

    assert found.fits
    assert found.changes == ()
    assert found.typical_mm == pytest.approx(0.0, abs=1e-6)


def test_a_few_readings_far_off_make_no_other_robot():
    spoilt = SEEN.position_mm.copy()
    spoilt[:3] += 900.0

    found = match(IRB_120, replace(SEEN, position_mm=spoilt), KNOWN)

    assert (found.fits, found.changes) == (True, ())


def test_one_mistake_is_one_change_and_two_are_two():
    turned = SEEN.joints_rad.copy()
    turned[:, 3] *= -1.0
    in_metres = SEEN.position_mm / 1000.0

    one = match(IRB_120, replace(SEEN, joints_rad=turned), KNOWN, search_zeros=False)
    both = match(IRB_120, replace(SEEN, joints_rad=turned, position_mm=in_metres), KNOWN, search_zeros=False)

    assert (one.fits, kinds(one)) == (True, ["other_way"])
    assert both.fits
    assert sorted(kinds(both)) == ["metres", "other_way"]


def test_a_zero_is_searched_for_where_that_is_asked():
    off = replace(SEEN, joints_rad=SEEN.joints_rad + np.radians([0, 0, 0, 0, -12.5, 0]))

    assert not match(IRB_120, off, KNOWN, search_zeros=False).fits
    found = match(IRB_120, off, KNOWN)
    assert found.fits
    assert len(found.changes) == 1


def test_of_several_robots_the_one_that_fits_goes_first_and_others_with_as_many_joints_are_no_answer():
    (found,) = matches((LONGER, IRB_120, SEVEN_AXES), SEEN, KNOWN)

    assert found.robot is IRB_120
    assert matches((SEVEN_AXES,), SEEN, KNOWN) == ()


def test_where_none_fits_all_are_told_the_likelier_first():
    noise = np.random.default_rng(0).uniform(-500.0, 500.0, SEEN.position_mm.shape)

    found = matches((LONGER, IRB_120), replace(SEEN, position_mm=noise), KNOWN)

    assert [one.fits for one in found] == [False, False]
    assert [one.changes for one in found] == [(), ()]
    shares = [one.typical_mm / plausible_mm(one.robot) for one in found]
    assert 1.0 < shares[0] <= shares[1]
