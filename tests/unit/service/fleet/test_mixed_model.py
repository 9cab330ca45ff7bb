"""The mixed model of a fleet against one dense covariance of all readings."""

import numpy as np
import pytest

from tests.helpers.fleet.linear import Dense, drawn
from truepose.fleet.mixed_model import Equations, NamedChange, Posterior, Variances

_ROBOT, _DAY = (0.3, 0.0, 0.1), 0.05  # one component that is nothing at all


@pytest.fixture(scope="module")
def made():
    return drawn(1)


@pytest.fixture(scope="module")
def posterior(made):
    return Posterior(Equations(made.fleet()), Variances(np.array(_ROBOT), _DAY))


def test_likelihoods_differ_as_those_of_all_readings_do(made, posterior):
    other = Posterior(posterior.equations, Variances(np.array([0.1, 0.2, 0.4]), 0.2))
    dense = Dense(made)

    differ = posterior.log_likelihood - other.log_likelihood

    expected = dense.log_likelihood(_ROBOT, _DAY) - dense.log_likelihood((0.1, 0.2, 0.4), 0.2)
    assert differ == pytest.approx(expected, abs=1e-7)


def test_what_robots_share_and_how_each_differs_are_best_predictions(made, posterior):
    dense = Dense(made)

    assert posterior.shared[:3] == pytest.approx(dense.common(_ROBOT, _DAY), abs=1e-9)
    for robot in range(6):
        expected = dense.deviation(_ROBOT, _DAY, robot)
        assert posterior.deviation[robot] == pytest.approx(expected, abs=1e-9)


def test_covariances_are_those_of_bayes_theorem(made, posterior):
    dense = Dense(made)
    covariance = dense.covariance(_ROBOT, _DAY)
    of_common = np.eye(3) - dense.columns[:3] @ np.linalg.solve(covariance, dense.columns[:3].T)
    cross = np.array(_ROBOT)[:, None] * dense.columns[:3] * (dense.robots == 2)
    of_robot = np.diag(_ROBOT) - cross @ np.linalg.solve(covariance, cross.T)

    assert posterior.covariance[:3, :3] == pytest.approx(of_common, abs=1e-9)
    assert posterior.deviation_covariance[2] == pytest.approx(of_robot, abs=1e-9)
    assert posterior.robot_now(2)[1][:3, :3] == pytest.approx(of_robot, abs=1e-9)


def test_a_named_change_is_found_at_its_size():
    made = drawn(2, readings=60, drift=lambda i, k, month: np.array([0.0, 0.0, 0.4 * month * (i == 3), 0.0]))
    fleet = made.fleet()
    shape = np.where(fleet.robot == 3, fleet.day / 90.0, 0.0)
    direction = np.array([[0.0], [0.0], [1.0], [0.0]])

    found = Posterior(Equations(fleet, [NamedChange(direction, shape)]), Variances(np.full(3, 0.2), 0.05))

    place = found.equations.of_change(0)
    spread = float(np.sqrt(found.covariance[place, place][0, 0]))
    assert found.shared[place][0] == pytest.approx(1.2, abs=4.0 * spread)
    assert spread < 0.1
