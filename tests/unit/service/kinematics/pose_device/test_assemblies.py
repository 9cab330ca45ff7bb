import numpy as np
import pytest

from tests.helpers.ballbar.pose_device import ALL, CUPS, FOUR_CUPS, MEASURABLE, NESTS, lengths
from truepose.domain.errors import ConfigurationError
from truepose.kinematics.pose_device import assemblies, distinct, measurable, turn_between


def test_of_144_assemblies_72_are_measurable_and_54_distinct():
    assert len(ALL) == 144
    assert len(MEASURABLE) == 72
    assert len(distinct(MEASURABLE)) == 54


def test_a_fourth_cup_gives_four_times_as_many():
    all_of_four = assemblies(FOUR_CUPS, NESTS)
    measurable_of_four = measurable(all_of_four, FOUR_CUPS, NESTS)

    assert (len(all_of_four), len(measurable_of_four)) == (576, 288)
    assert len(distinct(measurable_of_four)) == 4 * 54  # no two faces of the tetrahedron share a pose


def test_every_assembly_is_a_rigid_motion_of_the_tool_with_six_legs_of_300_mm():
    for one in ALL:
        assert one.pose.points(NESTS) == pytest.approx(one.points_mm, abs=2e-3)  # the nests are given to 1 um
        assert lengths(one.pose, one.legs) == pytest.approx(np.full(6, 300.0), abs=2e-3)
        assert np.linalg.det(one.pose.rotation) == pytest.approx(1.0)


def test_two_of_the_four_solutions_want_the_tool_the_other_way_round():
    # three turns of the tool for each solution: the even ones for two solutions, the odd ones for the others
    for base in {one.design.base for one in ALL}:
        tools = {
            solution: {
                one.design.tool for one in MEASURABLE if one.solution == solution and one.design.base == base
            }
            for solution in (1, 2, 3, 4)
        }
        assert [len(of_one) for of_one in tools.values()] == [3, 3, 3, 3]
        assert tools[1] == tools[3]
        assert tools[2] == tools[4]
        assert not tools[1] & tools[2]


def test_a_tool_turned_inside_out_measures_the_other_half():
    mirrored = NESTS * [1.0, 1.0, -1.0]

    others = measurable(assemblies(CUPS, mirrored), CUPS, mirrored)

    shapes = {(one.design, one.solution) for one in MEASURABLE}
    assert len(others) == 72
    assert not shapes & {(one.design, one.solution) for one in others}


def test_what_is_dropped_is_within_30_degrees_and_50_mm_of_something_kept():
    kept = distinct(MEASURABLE)
    dropped = [one for one in MEASURABLE if one not in kept]

    for one in dropped:
        turns = np.degrees([turn_between(one.pose.rotation, other.pose.rotation) for other in kept])
        apart = [np.linalg.norm(one.pose.origin_mm - other.pose.origin_mm) for other in kept]
        assert any(turn < 30.0 and distance < 50.0 for turn, distance in zip(turns, apart, strict=True))
    assert len(dropped) == 18


def test_poses_that_share_only_the_place_or_only_the_turn_are_both_kept():
    one = MEASURABLE[0]

    assert len(distinct(MEASURABLE, turn_rad=0.0)) == 72
    assert len(distinct(MEASURABLE, distance_mm=0.0)) == 72
    assert distinct([one, one]) == (one,)


def test_of_nothing_nothing_is_distinct():
    assert distinct([]) == ()


def test_legs_too_short_to_meet_give_no_assembly():
    assert assemblies(CUPS, NESTS, leg_mm=150.0) == ()


@pytest.mark.parametrize("which", [assemblies, lambda cups, nests: measurable(ALL, cups, nests)])
def test_nests_on_a_line_are_refused(which):
    on_a_line = np.array([[0.0, 0.0, 125.0], [75.0, 0.0, 125.0], [150.0, 0.0, 125.0]])

    with pytest.raises(ConfigurationError, match="on a line"):
        which(CUPS, on_a_line)


def test_a_flange_in_the_plane_of_the_nests_is_refused():
    flat = NESTS - NESTS.mean(axis=0)

    with pytest.raises(ConfigurationError, match="neither side is free"):
        measurable(assemblies(CUPS, flat), CUPS, flat)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-4, 1.0, 3.0, np.pi])
def test_the_turn_between_rotations_is_right_from_none_to_half_a_turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    # near half a turn the chord is flat: rounding of 1e-16 counts as its square root
    assert turn_between(np.eye(3), turned) == pytest.approx(angle, abs=5e-8)


def test_an_assembly_is_named_by_its_legs_and_solution():
    assert ALL[0].name == "1_12 2_123 3_1, solution 1"
    assert [one.number for one in ALL] == list(range(1, 145))
