"""A cause over the months, against generalised least squares."""

import numpy as np
import pytest

from tests.helpers.fleet.linear import Dense, drawn
from truepose.fleet.causes import robot_causes
from truepose.fleet.changes import Account, AlternativesTried
from truepose.fleet.mixed_model import Equations, estimate
from truepose.fleet.trend import course

_GAP = np.array([0.0, 0.0, 1.0, 0.0])


@pytest.fixture(scope="module")
def made():
    return drawn(41, readings=40, drift=lambda i, k, month: 0.6 * month * (i == 4) * _GAP)


@pytest.fixture(scope="module")
def account(made):
    fleet = made.fleet()
    return Account(fleet, estimate(Equations(fleet)), np.ones(6), (), AlternativesTried((), (), {}, 0.01))


def _link(account):
    return next(one for one in robot_causes(account.fleet) if one.subject == "link 4")


def test_each_campaign_says_what_least_squares_say(made, account):
    dense, variances = Dense(made), account.estimated.variances
    covariance = dense.covariance(variances.robot, variances.day)
    cause = _link(account)
    later = [(dense.robots == 4) & (dense.days == day) for day in (30.0, 60.0, 90.0)]
    unit = cause.directions.T @ dense.columns  # (q, m)
    moved = np.concatenate([unit * rows for rows in later]).T
    information = moved.T @ np.linalg.solve(covariance, moved) + np.eye(moved.shape[1])
    expected = np.linalg.solve(information, moved.T @ np.linalg.solve(covariance, dense.read))

    found = course(account, "robot 4", cause)

    assert found.amount.reshape(-1) == pytest.approx(expected, abs=1e-8)
    q = cause.directions.shape[1]
    spread = np.linalg.inv(information)
    for number in range(3):
        here = slice(number * q, (number + 1) * q)
        assert found.covariance[number] == pytest.approx(spread[here, here], abs=1e-9)


def test_what_grows_rises_and_what_does_not_stays(account):
    grown, steady = (course(account, robot, _link(account)) for robot in ("robot 4", "robot 1"))

    assert grown.day.tolist() == [30.0, 60.0, 90.0]
    assert np.all(np.diff(grown.amount[:, -1]) > 0.0)
    spread = np.sqrt(steady.covariance[:, -1, -1])
    assert np.all(np.abs(steady.amount[:, -1]) < 4.0 * spread)
