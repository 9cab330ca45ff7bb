import numpy as np

from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.true_robot import PlantSizes, draw_compliances, draw_motions

ARM = ARMS["irb120"]


def test_drawn_errors_have_the_stated_sizes():
    sizes = PlantSizes()
    rng = np.random.default_rng(1)

    drawn = np.array([draw_motions(ARM, sizes, rng) for _ in range(400)])

    links = drawn[:, 1:7]
    expected = [0.12, 0.12, 0.12, 0.35e-3, 0.35e-3, 0.8e-3]
    # Standard deviation of 2400 draws is itself good to 1/sqrt(2 * 2400) = 1.4 %; four of these.
    assert np.allclose(links.std(axis=(0, 1)), expected, rtol=0.06)
    assert np.allclose(drawn[:, 0].std(axis=0), [0.1] * 3 + [0.3e-3] * 3, rtol=0.15)
    assert not drawn[:, 7].any()  # the tool sits where its certificate says


def test_without_tilt_only_the_y_rotation_of_the_parallel_axis_is_absent():
    tilted = draw_motions(ARM, PlantSizes(), np.random.default_rng(2))

    clean = draw_motions(ARM, PlantSizes(parallel_axis_tilt_rad=0.0), np.random.default_rng(2))

    assert np.argwhere(tilted != clean).tolist() == [[3, 4]]
    assert clean[3, 4] == 0.0


def test_compliances_lie_between_their_factors():
    drawn = draw_compliances(ARM, PlantSizes(), np.random.default_rng(3))

    factors = drawn / np.array(ARM.typical_compliance_rad_per_n_mm)
    assert (factors >= 0.8).all()
    assert (factors <= 1.25).all()
