import numpy as np
import pytest

from tests.helpers.reference import reference

TURN_DEG = np.random.default_rng(4).uniform(-170, 170, (12, 6))


def test_a_gain_adds_its_share_of_the_angle_from_its_time_on(rigid_bench, at):
    gain = rigid_bench.effect("joint_gain", "joint 3", 1e-3, from_s=10.0)

    added = rigid_bench.added_rad(
        at([[0.0, 0.0, 30.0, 0.0, 0.0, 0.0]] * 2, time_s=np.array([9.9, 10.0])), gain
    )

    expected = np.zeros((2, 6))
    expected[1, 2] = 1e-3 * np.radians(30.0)
    assert added == pytest.approx(expected, abs=1e-16)  # rounding of the angle it was added to


@pytest.mark.parametrize(("order", "period_deg"), [(2.0, 180.0), (1.5, 240.0), (50.0, 7.2), (100.0, 3.6)])
def test_a_wave_comes_back_after_its_period_and_turns_its_sign_after_half_of_it(
    rigid_bench, at, order, period_deg
):
    wave = rigid_bench.effect("joint_harmonics", "joint 6", 0.03, order=order)
    later = np.zeros(6)
    later[5] = period_deg

    now, after, halfway = (
        rigid_bench.added_rad(at(TURN_DEG + part * later), wave) for part in (0.0, 1.0, 0.5)
    )

    # 0.0005 rad times what 100 periods of a turn lose of sixteen digits
    assert after == pytest.approx(now, abs=1e-15)
    assert halfway == pytest.approx(-now, abs=1e-15)
    assert not now[:, :5].any()


def test_the_amplitude_of_a_wave_is_half_of_peak_to_peak(rigid_bench, at):
    wave = rigid_bench.effect("joint_harmonics", "joint 1", 0.005, order=2.0)
    joints = np.zeros((721, 6))
    joints[:, 0] = np.linspace(-90.0, 90.0, 721)  # one period in steps of half a degree

    added = np.degrees(rigid_bench.added_rad(at(joints), wave)[:, 0])

    # 721 points miss a crest by at most 1/1440 of a period: 1 - cos(2 pi / 1440) = 1e-5
    assert (added.max() - added.min()) / 2 == pytest.approx(0.005, rel=1e-5)


def test_a_stated_phase_is_where_the_wave_stands_at_zero(rigid_bench, at):
    wave = rigid_bench.effect("joint_harmonics", "joint 4", 0.02, order=3.0, phase_deg=30.0)

    added = rigid_bench.added_rad(at([0.0] * 6), wave)

    assert np.degrees(added[0, 3]) == pytest.approx(0.01, rel=1e-12)


def test_a_drawn_phase_depends_on_the_seed_alone(rigid_bench, at):
    waves = [rigid_bench.effect("joint_harmonics", "joint 4", 0.02, seed=seed) for seed in (1, 1, 2)]

    first, same, other = (rigid_bench.added_rad(at(TURN_DEG), wave) for wave in waves)

    assert np.array_equal(first, same)
    assert not np.allclose(first, other, atol=1e-5)


def test_a_joint_is_dragged_by_its_source_and_by_no_other(rigid_bench, at):
    coupling = rigid_bench.effect("joint_coupling", "joint 6", 5e-4, source="joint 4")

    added = rigid_bench.added_rad(at(TURN_DEG), coupling)

    assert added[:, 5] == pytest.approx(5e-4 * np.radians(TURN_DEG[:, 3]), abs=1e-15)
    assert not added[:, :5].any()


@pytest.mark.parametrize(("moved", "source"), [(6, 5), (5, 4), (1, 2)])
def test_without_source_the_neighbour_drags(rigid_bench, at, moved, source):
    coupling = rigid_bench.effect("joint_coupling", f"joint {moved}", 1e-4)

    added = rigid_bench.added_rad(at(TURN_DEG), coupling)

    assert added[:, moved - 1] == pytest.approx(1e-4 * np.radians(TURN_DEG[:, source - 1]), abs=1e-15)


def test_backlash_is_half_a_gap_short_from_either_side_and_none_where_the_side_is_unknown(rigid_bench, at):
    gap = rigid_bench.effect("backlash", "joint 5", 0.04)
    direction = np.array([[1.0] * 6, [-1.0] * 6, [0.0] * 6])

    added = np.degrees(rigid_bench.added_rad(at([[10.0] * 6] * 3, direction=direction), gap))

    assert added[:, 4] == pytest.approx([-0.02, 0.02, 0.0], abs=1e-15)
    assert not added[:, [0, 1, 2, 3, 5]].any()


def test_backlash_of_all_joints_is_the_published_table_at_its_largest_gap(rigid_bench, at):
    gaps = rigid_bench.effect("backlash", "joints", 0.037)

    from_above = rigid_bench.added_rad(at([10.0] * 6, direction=-np.ones((1, 6))), gaps)
    from_below = rigid_bench.added_rad(at([10.0] * 6), gaps)

    table = reference("thesis_axes")["backlash_deg"]
    assert np.degrees(from_above - from_below)[0] == pytest.approx(
        table, abs=1e-13
    )  # rounding of angles of 10 deg
