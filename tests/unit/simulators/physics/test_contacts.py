"""What the tool meets in a closed loop, against the formulas of school geometry."""

import numpy as np
import pytest

from truepose_simulators.physics.contacts import BallAtSensor, Plane, PlaneAtSensor, Sphere
from truepose_simulators.physics.rigid import motion, move, pose_matrix, rotation

RNG = np.random.default_rng(4)
FRAMES = pose_matrix(300.0 * RNG.standard_normal((6, 3)), RNG.uniform(-1.0, 1.0, (6, 3)))
NESTS = 100.0 * RNG.standard_normal((6, 3))
PLACES = move(FRAMES, NESTS)
CENTRE = np.array([400.0, -50.0, 120.0])


def test_a_sphere_is_as_far_as_its_centre_less_the_zero():
    read = Sphere(CENTRE, 15.7).read_mm(FRAMES, NESTS)

    assert read[:, 0] == pytest.approx(np.sqrt(((PLACES - CENTRE) ** 2).sum(axis=1)) - 15.7, abs=1e-9)


def test_a_face_reads_the_distance_along_its_normal():
    axes = rotation(np.array([0.3, -0.2, 0.9]))

    read = Plane(motion(CENTRE, axes)).read_mm(FRAMES, NESTS)

    assert read[:, 0] == pytest.approx((PLACES - CENTRE) @ axes[:, 2], abs=1e-9)


def test_a_sensor_reads_the_ball_along_the_axes_that_the_tool_carries():
    sensor = rotation(np.array([0.1, 0.4, -0.2]))

    read = BallAtSensor(CENTRE, sensor).read_mm(FRAMES, NESTS)

    for axis in range(3):
        along = FRAMES[:, :3, :3] @ sensor[:, axis]
        assert read[:, axis] == pytest.approx(((CENTRE - PLACES) * along).sum(axis=1), abs=1e-9)


def test_a_beam_ends_where_it_meets_the_plane():
    axes, sensor = rotation(np.array([0.3, -0.2, 0.9])), rotation(np.array([0.1, 0.4, -0.2]))

    read = PlaneAtSensor(motion(CENTRE, axes), sensor).read_mm(FRAMES, NESTS)

    met = PLACES + read * (FRAMES[:, :3, :3] @ sensor[:, 2])
    assert (met - CENTRE) @ axes[:, 2] == pytest.approx(np.zeros(6), abs=1e-9)


def test_a_beam_along_the_plane_never_meets_it():
    along, across = rotation(np.array([0.0, np.pi / 2.0, 0.0])), np.eye(3)
    frames = pose_matrix(np.array([[0.0, 0.0, 30.0], [0.0, 0.0, 0.0]]), np.zeros((2, 3)))

    read = PlaneAtSensor(np.eye(4), np.round(along)).read_mm(frames, np.zeros((2, 3)))

    assert read.tolist() == [[np.inf], [np.inf]]
    assert PlaneAtSensor(np.eye(4), across).read_mm(frames, np.zeros((2, 3))).tolist() == [[-30.0], [0.0]]
