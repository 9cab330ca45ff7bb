"""The base fixture: its cups, what carries them, and where they open."""

from itertools import combinations

import numpy as np
import pytest

from tests.helpers.ballbar.cells import frame
from truepose.domain.errors import ConfigurationError
from truepose.kinematics.pose_device import fourth_cup
from truepose.planning.ballbar.bodies import base_fixture, fixture_body

PLACE = frame(400, -100, 200, 20, -30, 50)


@pytest.mark.parametrize("points", [3, 4])
def test_every_two_cups_are_300_mm_apart(points):
    cups = base_fixture(1, PLACE, points).cups_mm

    sides = [np.linalg.norm(a - b) for a, b in combinations(cups, 2)]

    assert len(sides) == points * (points - 1) // 2
    assert sides == pytest.approx([300.0] * len(sides))


def test_the_fourth_cup_is_where_the_pose_device_expects_it():
    fixture = base_fixture(1, PLACE, 4)

    expected = fourth_cup(fixture.own_cups_mm[:3], 300.0, 300.0, 300.0)

    assert fixture.own_cups_mm[3] == pytest.approx(expected)


def test_the_frame_has_cup_1_as_origin_and_cup_2_on_x():
    fixture = base_fixture(1, PLACE, 3)

    assert fixture.own_cups_mm[0] == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert fixture.own_cups_mm[1] == pytest.approx([300.0, 0.0, 0.0], abs=1e-9)
    assert fixture.cups_mm[0].tolist() == [400.0, -100.0, 200.0]


def test_three_cups_open_along_the_normal_and_carry_poses_together():
    fixture = base_fixture(1, PLACE, 3)

    assert fixture.faces == ((1, 2, 3),)
    assert fixture.axes == pytest.approx(np.tile(fixture.normal, (3, 1)))


def test_of_a_level_tetrahedron_on_its_tip_only_the_upper_face_carries_poses():
    fixture = base_fixture(1, frame(400, 0, 300), 4)

    assert fixture.faces == ((1, 2, 3),)


def test_of_a_tetrahedron_upright_three_faces_carry_poses_and_their_cups_open_between_them():
    fixture = base_fixture(1, frame(400, 0, 100, 180), 4)

    assert sorted(fixture.faces) == [(1, 2, 4), (1, 3, 4), (2, 3, 4)]
    assert fixture.axes[3] == pytest.approx([0.0, 0.0, 1.0])
    assert np.all(fixture.axes[:3, 2] > 0.0)


def test_the_body_reaches_from_the_cups_to_the_table():
    fixture = base_fixture(1, PLACE, 3)

    body = fixture_body(fixture, 30.0)

    assert body.end_mm[..., 2].min() == 30.0
    assert np.linalg.norm(body.start_mm[:3, 0] - fixture.cups_mm, axis=1) == pytest.approx([10.0] * 3)


@pytest.mark.parametrize("points", [0, 2, 5])
def test_another_number_of_cups_is_refused(points):
    with pytest.raises(ConfigurationError, match="3 or 4 cups"):
        base_fixture(1, PLACE, points)


@pytest.mark.parametrize("side", [0.0, -1.0, np.inf, np.nan])
def test_a_side_that_is_no_length_is_refused(side):
    with pytest.raises(ConfigurationError, match="distance between the cups"):
        base_fixture(1, PLACE, 3, side)
