"""The cube that commanded poses were taken from."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.kinematics.frames import rotation_xyz
from truepose.validation.iso9283.plan import Cube
from truepose.validation.iso9283.visits import CommandedPose, cube_of

_CUBE = Cube((370.0, -20.0, 400.0), 200.0)


def moved(number, away_mm, poses=_CUBE.poses):
    """One pose somewhere else."""
    place = np.array(poses[number - 1].position_mm) + away_mm
    changed = CommandedPose(number, tuple(place.tolist()))
    return tuple(changed if pose.number == number else pose for pose in poses)


@pytest.mark.parametrize("plane", ["x+", "x-", "y+", "y-"])
def test_the_cube_of_a_plan_is_found_again(plane):
    found = cube_of(replace(_CUBE, plane=plane).poses)

    assert found.edge_mm == pytest.approx(200.0)
    assert found.centre_mm == pytest.approx((370.0, -20.0, 400.0))


def test_the_frame_of_the_readings_does_not_matter():
    turn = rotation_xyz(0.4, -1.1, 2.0)
    turned = [CommandedPose(p.number, tuple((turn @ p.position_mm).tolist())) for p in _CUBE.poses]

    assert cube_of(turned).edge_mm == pytest.approx(200.0)


def test_poses_that_lie_a_little_off_are_still_of_the_cube():
    assert cube_of(moved(3, (5.0, 0.0, 0.0))) is not None  # 0.014 of the diagonal


@pytest.mark.parametrize(("number", "away_mm"), [(1, (0.0, 0.0, 30.0)), (4, (0.0, 60.0, 0.0))])
def test_poses_that_lie_otherwise_are_of_none(number, away_mm):
    assert cube_of(moved(number, away_mm)) is None


def test_four_poses_are_of_none():
    assert cube_of(_CUBE.poses[:4]) is None
