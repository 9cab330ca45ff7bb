import numpy as np
import pytest


def test_a_drifting_instrument_has_come_its_way_after_an_hour(bench):
    drift = bench.effect(
        "instrument_drift",
        "tracker",
        0.06,
        from_s=1800.0,
        direction=[1, 0, 0],
        rotation_rad_per_h=5e-5,
        axis=[0, 0, 1],
    )

    come = drift.frame_motion(np.array([0.0, 1800.0, 5400.0]))

    assert not come[:2].any()
    assert come[2] == pytest.approx([0.06, 0, 0, 0, 0, 5e-5], rel=1e-12)


def test_a_wrong_scale_holds_from_its_time_on(bench):
    scale = bench.effect("instrument_scale", "tracker", 20e-6, from_s=10.0)

    assert scale.relative_scale(np.array([9.0, 10.0])).tolist() == [0.0, 20e-6]


def test_swapped_labels_name_the_other_nest_and_leave_a_third_alone(bench):
    swap = bench.effect("label_swap", "nest 1, nest 3", 1.0, from_s=5.0)

    read = swap.nests_read(np.array([1, 2, 3, 1]), np.array([5.0, 5.0, 5.0, 4.0]), np.random.default_rng(1))

    assert read.tolist() == [3, 2, 1, 1]


def test_a_share_of_labels_is_swapped(bench):
    swap = bench.effect("label_swap", "nest 1, nest 2", 0.25)

    read = swap.nests_read(np.ones(4000, dtype=int), np.zeros(4000), np.random.default_rng(2))

    # Binomial: sqrt(0.25 * 0.75 / 4000) = 0.0068, four of these.
    assert np.mean(read == 2) == pytest.approx(0.25, abs=0.028)


def test_a_share_of_readings_is_off_by_the_stated_distance_in_any_direction(bench):
    bad = bench.effect("outliers", "readings", 0.03, size_mm=0.3)

    off = bad.displacement_mm(np.zeros(20_000), np.random.default_rng(3))

    distance = np.linalg.norm(off, axis=1)
    hit = distance > 0.0
    assert distance[hit] == pytest.approx(0.3, rel=1e-12)
    # Binomial: sqrt(0.03 * 0.97 / 20,000) = 0.0012, four of these; mean of directions: sqrt(1 / 3 / 600).
    assert hit.mean() == pytest.approx(0.03, abs=0.005)
    assert np.abs(off[hit].mean(axis=0)).max() < 4 * 0.3 * np.sqrt(1 / 3 / 600)


def test_a_wrong_scale_of_the_ballbar_is_none_of_the_tracker(bench):
    scale = bench.effect("instrument_scale", "ballbar", 20e-6, from_s=10.0)

    assert scale.relative_length(np.array([9.0, 10.0])).tolist() == [0.0, 20e-6]
    assert not hasattr(scale, "relative_scale")


def test_every_initialisation_leaves_its_own_zero_for_as_long_as_it_lasts(bench):
    zero = bench.effect("ballbar_zero", "ballbar", 0.01)
    numbers = np.repeat(np.arange(1, 801), 2)

    errors = zero.zero_mm(numbers, np.tile([10.0, 60.0], 800), np.zeros(1600)).reshape(800, 2)

    assert np.array_equal(errors[:, 0], errors[:, 1])
    # Relative scatter of a standard deviation of 800 draws: 1 / sqrt(1600) = 0.025, four of these.
    assert errors[:, 0].std() == pytest.approx(0.01, rel=0.1)


def test_a_growing_zero_begins_at_nothing_and_is_grown_after_its_time(bench):
    constant, growing = (
        bench.effect("ballbar_zero", "ballbar", 0.01, course=course, grown_s=60.0)
        for course in ("constant", "growing")
    )
    one = np.array([3, 3, 3])

    errors = growing.zero_mm(one, np.array([0.0, 30.0, 60.0]), np.zeros(3))

    grown = constant.zero_mm(one[:1], np.zeros(1), np.zeros(1))[0]
    assert errors == pytest.approx([0.0, grown / 2.0, grown], rel=1e-12)


def test_a_zero_is_right_until_the_time_of_the_change(bench):
    zero = bench.effect("ballbar_zero", "ballbar", 0.01, from_s=100.0)

    errors = zero.zero_mm(np.array([1, 1]), np.zeros(2), np.array([99.0, 100.0]))

    assert errors[0] == 0.0
    assert errors[1] != 0.0


def test_a_fixture_moves_in_its_own_placement_only(bench):
    shift = bench.effect(
        "fixture_shift",
        "placement 2",
        0.1,
        from_s=50.0,
        direction=[0, 1, 0],
        rotation_rad=1e-4,
        axis=[1, 0, 0],
    )

    moved = shift.fixture_motion(np.array([1, 2, 2]), np.array([60.0, 40.0, 50.0]))

    assert not moved[:2].any()
    assert moved[2] == pytest.approx([0, 0.1, 0, 1e-4, 0, 0], abs=1e-15)
