"""Ballbar poses, ways and places of the base fixture keep out of the volumes of the cell."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell, fixture_before_the_arm
from truepose.domain.cell import Box, CellLimits, Cylinder, HalfSpace, KeepOuts
from truepose.planning.ballbar.bodies import chain_of
from truepose.planning.ballbar.motion_clearance import between
from truepose.planning.ballbar.placements import PlacementRequest, suggest
from truepose.planning.ballbar.plan import plan_at
from truepose.planning.ballbar.poses import reach
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.prediction.ballbar import plan_with_fixtures

FIXTURE = fixture_before_the_arm()
LID = HalfSpace("lid", (0.0, 0.0, 740.0), (0.0, 0.0, -1.0))
ELBOW_MM = 740.0 - 10.0 - 70.0  # the room kept and half the width of the upper arm: no elbow is higher
FREE = ballbar_cell()
UNDER_LID = ballbar_cell(keep_outs=KeepOuts(half_spaces=(LID,)))


def highest_mm(joints_rad):
    """Height of the highest of the arm's frames and nests at configurations (n, J)."""
    chain = chain_of(FREE, joints_rad)
    nests = np.array([chain.points(nest) for nest in FREE.nests_mm])
    return max(chain.origin[1:, :, 2].max(), nests[..., 2].max())


def test_only_poses_outside_are_measured():
    free, kept = reach(FREE, FIXTURE), reach(UNDER_LID, FIXTURE)

    assert highest_mm(free.joints_rad) > ELBOW_MM  # the lid is low enough to matter
    assert 0 < len(kept) < len(free)
    assert highest_mm(kept.joints_rad) < ELBOW_MM


def test_no_bar_goes_through_a_volume_that_the_arm_never_comes_near():
    middle = FIXTURE.cups_mm.mean(axis=0) + np.array([-60.0, 60.0, 60.0])
    pole = Cylinder("pole", tuple(middle - 5.0), tuple(middle + 5.0), 10.0)

    kept = reach(ballbar_cell(keep_outs=KeepOuts(cylinders=(pole,))), FIXTURE)

    share = np.linspace(0.12, 0.88, 60)[:, None]  # the body of the bar, between its slim ends
    chain = chain_of(FREE, kept.joints_rad)
    nests = np.array([chain.points(nest) for nest in FREE.nests_mm])
    assert 0 < len(kept) < len(reach(FREE, FIXTURE))
    for row, assembly in enumerate(kept.assembly):
        for base, tool in assembly.legs:
            cup, nest = FIXTURE.cups_mm[base - 1], nests[tool - 1, row]
            along = cup + share * (nest - cup)
            assert np.linalg.norm(along - middle, axis=1).min() > 15.0


def test_no_way_of_a_session_leads_through_a_volume():
    (placement,) = plan_at(UNDER_LID, [FIXTURE], 6).placements

    assert any(pose.via_rad for pose in placement.poses[1:])
    for before, pose in pairwise(placement.poses):
        points = [np.array(p) for p in (before.joints_rad, *pose.via_rad, pose.joints_rad)]
        assert all(highest_mm(between(a, b)) < ELBOW_MM + 1.0 for a, b in pairwise(points))


def test_the_base_fixture_is_not_put_into_a_volume():
    left = KeepOuts(half_spaces=(HalfSpace("aisle", (0.0, 200.0, 0.0), (0.0, -1.0, 0.0)),))

    (fixture,) = suggest(
        ballbar_cell(keep_outs=left), PlacementRequest(poses=6, draws=60, moves=0, starts=1, seed=2)
    ).fixtures

    assert fixture.cups_mm[:, 1].max() < 200.0


def test_a_promise_counts_only_poses_outside_and_names_the_volumes_where_they_are_too_few():
    cell = domain_cell()
    kept = replace(cell, limits=replace(cell.limits, keep_outs=UNDER_LID.keep_outs))
    offered = plan_with_fixtures(kept, [FIXTURE]).curve[-1].n

    assert offered == len(reach(UNDER_LID, FIXTURE))
    with pytest.raises(TooFewCandidatesError, match="keep-out volumes as well: lid"):
        plan_with_fixtures(kept, [FIXTURE], offered + 1)


def test_a_volume_far_from_everything_changes_nothing():
    far = KeepOuts((Box("far", (5000.0, 5000.0, 0.0), (6000.0, 6000.0, 100.0)),))

    plans = [
        plan_with_fixtures(domain_cell(limits=CellLimits(keep_outs=k)), [FIXTURE], 12)
        for k in (KeepOuts(), far)
    ]

    assert np.array_equal(plans[0].joints_rad, plans[1].joints_rad)
