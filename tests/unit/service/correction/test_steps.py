"""Steps of many arms at once against one system of equations after the other."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import extended, stops_and_nests
from truepose.correction.inverse import LEVER_MM, damped_steps
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.kinematics.frames import cross


@pytest.fixture(scope="module")
def state():
    estimate = identified_estimate(extended(IRB_120))
    return evaluate(estimate.structure, estimate.values, Targets(*stops_and_nests(IRB_120, 30)))


def test_a_short_step_makes_up_for_the_error_of_a_rigid_arm(state):
    rows, sign = np.arange(30)[::-2], np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
    turn = 1e-4 * np.random.default_rng(1).standard_normal((len(rows), 6))
    shift = cross(state.chain.z[:, rows], state.unscaled_mm[rows] - state.chain.origin[:, rows])
    moved = np.concatenate([shift, LEVER_MM * state.chain.z[:, rows]], axis=2)
    error = np.einsum("jni,nj->ni", moved, turn * sign)

    steps = damped_steps(state, rows, error, sign)

    # damping: a ten-thousandth of the squared error against squared levers of more than (10 mm)^2
    assert np.median(np.abs(steps - turn).max(axis=1)) < 1e-9
    assert np.all(np.abs(steps - turn).max(axis=1) < 1e-5)


def test_no_step_is_longer_than_allowed(state):
    error = np.full((1, 6), 1e4)

    steps = damped_steps(state, np.array([0]), error, np.ones(6))

    assert np.abs(steps).max() == pytest.approx(0.3)


def test_an_error_of_nothing_asks_for_no_step(state):
    assert not damped_steps(state, np.arange(30), np.zeros((30, 6)), np.ones(6)).any()
