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
