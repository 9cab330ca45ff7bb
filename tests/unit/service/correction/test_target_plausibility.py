"""Targets in the wrong unit, frame or order: what was meant is named, and nothing where all is well."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import LOADED_SEVEN_AXES, extended, model_of
from tests.helpers.identification.synthetic import configurations
from truepose.correction import likely_mistake, of_poses
from truepose.correction.target_plausibility import _explains
from truepose.domain.robot import FramePlacement
from truepose.identification.model.validity import measured_zone
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of

SIDE = configurations(60, 4) * np.array([0.2, 1.0, 1.0, 1.0, 1.0, 1.0]) + np.eye(6)[0]
MIRROR = np.diag([1.0, -1.0, 1.0])


BASE = FramePlacement(1800.0, 900.0, 100.0)


@pytest.fixture(scope="module")
def model():
    """An arm that was measured on its left side, some way from the origin of the readings."""
    return replace(model_of(IRB_120, base=BASE), zone=measured_zone(IRB_120, SIDE))


@pytest.fixture(scope="module")
def in_base():
    """Places on that side."""
    chain = nominal_chain(IRB_120, SIDE[::2])
    return of_poses(poses_of(chain.end_rotation, chain.end_origin), 6)


@pytest.fixture(scope="module")
def goals(in_base):
    """The same in the world."""
    return replace(in_base, position_mm=in_base.position_mm + np.array([BASE.x_mm, BASE.y_mm, BASE.z_mm]))


def key(model, goals, *, in_base=False):
    found = likely_mistake(model, goals, in_base=in_base)
    return None if found is None else found.key.removeprefix("corrections.mistake.")


def test_of_targets_where_the_robot_works_nothing_is_said(model, goals):
    assert key(model, goals) is None


@pytest.mark.parametrize(
    ("unit", "length"), [("metres", 1e-3), ("inches", 1 / 25.4), ("centimetres", 0.1), ("micrometres", 1e3)]
)
def test_lengths_in_another_unit_are_named(model, goals, unit, length):
    assert key(model, replace(goals, position_mm=length * goals.position_mm)) == unit


def test_left_handed_axes_are_named(model, goals):
    mirrored = replace(
        goals, position_mm=goals.position_mm @ MIRROR, rotation=MIRROR @ goals.rotation @ MIRROR
    )

    assert key(model, mirrored) == "mirrored"


def test_the_pose_of_the_base_as_the_tool_sees_it_is_named(model, goals):
    back = np.swapaxes(goals.rotation, 1, 2)
    position = -np.einsum("nij,nj->ni", back, goals.position_mm)

    assert key(model, replace(goals, position_mm=position, rotation=back)) == "inverse"


def test_the_other_frame_is_named(model, goals, in_base):
    assert key(model, in_base) == "base"
    assert key(model, goals, in_base=True) == "world"
    assert key(model, in_base, in_base=True) is None


def test_small_numbers_that_shrink_to_the_robots_own_base_are_metres(model, in_base):
    assert key(model, replace(in_base, position_mm=in_base.position_mm / 1000.0), in_base=True) == "metres"


def test_a_small_part_of_the_work_space_is_no_mistake(model, in_base):
    within = 0.1 * np.random.default_rng(0).standard_normal((30, 3))
    close = replace(in_base, position_mm=in_base.position_mm[0] + within, rotation=in_base.rotation[[0] * 30])

    assert key(model, close, in_base=True) is None


def test_what_nothing_explains_is_told_how_far_away_it_is(model, goals):
    above = replace(goals, position_mm=goals.position_mm + np.array([0.0, 0.0, 5000.0]))

    found = likely_mistake(model, above, in_base=False)

    assert found is not None
    assert found.key == "corrections.mistake.elsewhere"
    assert 3900.0 < dict(found.values)["away_mm"] < 5000.0


def test_a_few_new_places_and_one_or_two_targets_are_nobodys_mistake(model, goals):
    some = goals.position_mm.copy()
    some[:3, 2] += 3000.0

    assert key(model, replace(goals, position_mm=some)) is None
    assert key(model, replace(goals, position_mm=goals.position_mm / 1000.0).taken(np.arange(2))) is None


def test_an_arm_of_which_neither_zone_nor_branches_are_known_is_believed():
    joints = np.random.default_rng(0).uniform(-1.0, 1.0, (10, 7))
    chain = nominal_chain(LOADED_SEVEN_AXES, joints)
    shifted = of_poses(poses_of(chain.end_rotation, chain.end_origin + 700.0), 7)

    assert key(replace(extended(LOADED_SEVEN_AXES), zone=None), shifted) is None


@pytest.mark.parametrize(
    ("then", "now", "explained"),
    [
        (0.5, 0.0, True),
        (0.49, 0.0, False),
        (0.6, 0.15, True),
        (0.6, 0.16, False),
        (0.95, 0.75, True),
        (0.94, 0.75, False),
        (1.0, 0.76, False),
    ],
)
def test_another_reading_explains_where_hardly_any_or_nearly_all_are_in_place(then, now, explained):
    assert _explains(then, now) is explained
