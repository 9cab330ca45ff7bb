import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose.kinematics.trilateration import tri, tri_gradient

CENTRES = np.array([[0.0, 0.0, 0.0], [300.0, 0.0, 0.0], [150.0, 260.0, 0.0]])
COORDINATE = st.floats(-400.0, 400.0)
HEIGHT = st.floats(20.0, 400.0)


def lengths_to(point, centres=CENTRES):
    return np.linalg.norm(point - centres, axis=-1)


@given(COORDINATE, COORDINATE, HEIGHT, st.sampled_from([1.0, -1.0]))
def test_a_point_comes_back_from_its_three_distances(x, y, z, side):
    point = np.array([x, y, side * z])

    found = tri(*CENTRES, *lengths_to(point), side)

    # a height of 20 mm at 700 mm amplifies rounding (1e-13) by 35, the plane coordinates' squares by 1e3
    assert found == pytest.approx(point, abs=1e-9)


def test_centres_need_not_lie_at_the_origin_nor_in_a_plane_of_the_axes():
    rng = np.random.default_rng(1)
    centres, point = rng.normal(0.0, 300.0, (3, 50, 3)), rng.normal(0.0, 300.0, (50, 3))
    normal = np.cross(centres[1] - centres[0], centres[2] - centres[0])
    side = np.sign(np.einsum("ni,ni->n", point - centres[0], normal))

    found = tri(*centres, *(np.linalg.norm(point - centre, axis=1) for centre in centres), side)

    assert found == pytest.approx(point, abs=1e-6)  # among 50 random triangles a few are slender


def test_both_sides_are_mirror_images():
    above, below = tri(*CENTRES, 300.0, 310.0, 290.0, np.array([1.0, -1.0]))

    assert above == pytest.approx(below * [1.0, 1.0, -1.0])


def test_distances_that_do_not_meet_give_no_point():
    assert np.isnan(tri(*CENTRES, 100.0, 100.0, 100.0, 1.0)).all()


def test_centres_on_a_line_give_no_point():
    on_a_line = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [250.0, 0.0, 0.0]])

    assert np.isnan(tri(*on_a_line, 300.0, 300.0, 300.0, 1.0)).all()


def test_one_triple_without_a_point_does_not_disturb_the_others():
    first = np.array([300.0, 100.0])

    found = tri(*CENTRES, first, np.array([300.0, 100.0]), np.array([300.0, 100.0]), 1.0)

    assert np.isfinite(found[0]).all()
    assert np.isnan(found[1]).all()


def test_the_gradient_agrees_with_complex_steps():
    lengths = np.array([301.0, 280.0, 350.0])
    quantities = np.concatenate([CENTRES.ravel(), lengths])

    def point(values):
        return tri(*values[:9].reshape(3, 3), *values[9:], 1.0)

    steps = quantities + 1e-30j * np.eye(12)
    by_steps = np.stack([point(step).imag / 1e-30 for step in steps], axis=1)
    everything = np.eye(12)
    analytic = tri_gradient(point(quantities), CENTRES, everything[:9].reshape(3, 3, 12), everything[9:])

    assert analytic == pytest.approx(by_steps, abs=1e-12)  # a complex step has no truncation error


def test_the_gradient_of_a_point_in_the_plane_of_its_centres_is_refused():
    with pytest.raises(np.linalg.LinAlgError):
        tri_gradient(np.array([150.0, 80.0, 0.0]), CENTRES, np.zeros((3, 3, 3)), np.eye(3))
