"""Sentences of figures: what was planted is named, noise is called nothing."""

import numpy as np
import pytest

from truepose.messages.catalogue import catalogue, english
from truepose.reports.captions import (
    distances_sentence,
    errors_sentence,
    joints_sentence,
    neighbours_sentence,
    reach_sentence,
)

N, NOISE_MM = 200, 0.02
RUNS = 60  # of noise alone; a false alarm in a thousand is promised


def noise(seed, *shape):
    return np.random.default_rng(seed).normal(0.0, NOISE_MM, shape)


def joints_of(seed, n=N):
    return np.random.default_rng(seed + 1000).uniform(-2.6, 2.6, (n, 6))


def test_a_planted_wave_is_named_with_joint_order_and_size():
    joints, residual = joints_of(1), noise(1, 6, N, 3)
    residual[2, :, 0] += 0.03 * np.sin(2 * joints[:, 2] + 0.4)

    text = english(joints_sentence(joints, residual))

    assert text.startswith("Joint 3 shows a harmonic of order 2 per turn, 0.0")
    peak = float(text.split(", ")[1].split(" mm")[0])
    assert peak == pytest.approx(0.06, abs=0.012)  # three standard uncertainties of twice an amplitude


def test_several_waves_name_the_largest_and_count_the_others():
    joints, residual = joints_of(2), noise(2, 6, N, 3)
    residual[0, :, 1] += 0.03 * np.cos(joints[:, 0])
    residual[5, :, 2] += 0.05 * np.cos(3 * joints[:, 5])

    text = english(joints_sentence(joints, residual))

    assert text.startswith("Joint 6 shows the largest harmonic, order 3 per turn")
    assert "Number of joints with smaller harmonics: 1." in text
    assert (
        catalogue("fr")
        .spoken(joints_sentence(joints, residual))
        .startswith("L\N{RIGHT SINGLE QUOTATION MARK}axe 6")
    )


def test_noise_over_joints_is_nothing():
    alarms = [
        seed for seed in range(RUNS)
        if "No joint shows" not in english(joints_sentence(joints_of(seed), noise(seed, 6, N, 3)))
    ]  # fmt: skip

    assert alarms == []


def test_what_the_model_itself_is_uncertain_by_is_no_finding():
    joints, residual = joints_of(1), noise(1, 6, N, 3)
    residual[2, :, 0] += 0.03 * np.sin(2 * joints[:, 2])
    place = np.random.default_rng(6).uniform(-500, 500, (N, 3))
    alike = noise(6, N, 3) + 0.0001 * place

    assert "No joint shows" in english(joints_sentence(joints, residual, model_u_mm=0.03))
    assert "shows a harmonic" in english(joints_sentence(joints, residual, model_u_mm=0.01))
    assert "no more than expected from chance" in english(neighbours_sentence(place, alike, model_share=0.5))


def test_a_joint_that_hardly_moved_shows_no_wave():
    joints = np.random.default_rng(3).uniform(-0.1, 0.1, (N, 1))
    residual = 0.5 * joints.T[:, :, None]

    assert "No joint shows" in english(joints_sentence(joints, residual))


def test_few_readings_or_no_errors_are_nothing():
    assert "No joint shows" in english(joints_sentence(joints_of(4, 5), noise(4, 6, 5, 3)))
    assert "No joint shows" in english(joints_sentence(joints_of(4), np.zeros((6, N, 3))))


def test_errors_that_grow_with_reach_are_told_with_both_ends():
    reach = np.random.default_rng(5).uniform(200.0, 800.0, N)
    errors = 1e-4 * reach + np.abs(noise(5, N))

    text = english(reach_sentence(reach, errors))

    assert text.startswith("Errors grow with reach: 0.0")
    assert english(reach_sentence(-reach + 1000.0, errors)).startswith("Errors fall with reach")


def test_equal_errors_say_nothing_of_reach_in_whatever_order_they_come():
    reach, errors = np.sort(np.random.default_rng(5).uniform(200.0, 800.0, N)), np.full(N, 0.1)
    errors[N // 2] = 0.2

    assert "do not depend significantly" in english(reach_sentence(reach, errors))


def test_noise_over_reach_is_nothing():
    alarms = [
        seed for seed in range(RUNS)
        if "do not depend significantly"
        not in english(reach_sentence(np.random.default_rng(seed).uniform(0, 1, N), np.abs(noise(seed, N))))
    ]  # fmt: skip

    assert alarms == []
    assert "Too few" in english(reach_sentence(np.ones(N), np.abs(noise(1, N))))


def test_neighbours_that_point_alike_are_told_and_noise_is_nothing():
    place = np.random.default_rng(6).uniform(-500, 500, (N, 3))
    alike = noise(6, N, 3) + 0.0001 * place

    assert english(neighbours_sentence(place, alike)).startswith("Neighbouring arrows agree in direction (")
    assert all(
        "no more than expected from chance" in english(neighbours_sentence(place, noise(seed, N, 3)))
        for seed in range(RUNS)
    )
    assert "Too few" in english(neighbours_sentence(place, np.zeros((N, 3))))


def test_sizes_of_errors_say_where_nearly_all_lie_and_what_lies_far_out():
    before, after = np.full(100, 1.0), np.full(100, 0.03)
    after[7] = 0.4

    assert english(errors_sentence(before, after)) == (
        "With the model, 95 % of the errors are below 0.0300 mm; without it, below 1.000 mm. "
        "One reading lies beyond five times the median error: check it."
    )
    assert english(errors_sentence(after, before)).startswith("The model does not help")
    assert "Nothing was added to the model" in english(errors_sentence(before, before))


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.5, "No evident bias"), (0.6, "No evident bias"), (0.9, "too long"), (0.1, "too short")],
)
def test_distances_that_err_to_one_side_are_told(share, words):
    assert words in english(distances_sentence(0.02, share, 4950))


def test_no_pairs_show_nothing():
    assert "No evident bias" in english(distances_sentence(0.0, 1.0, 0))
