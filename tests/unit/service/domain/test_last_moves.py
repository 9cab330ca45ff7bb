"""Last moves: told by the order of times, not where the arm came from elsewhere."""

import numpy as np
import pytest

from truepose.domain.campaign import Stops
from truepose.domain.last_moves import with_moves

JOINTS = np.array([[0.1, 0.2], [0.1, 0.2], [0.5, -0.3], [0.4, 0.9]])  # two nests were read in the first
CONFIG = np.array([7, 7, 8, 9])
TIMES = np.array([10.0, 12.0, 30.0, 50.0])
NAN = (np.nan, np.nan)


def stops(**columns):
    return Stops(**({"config": CONFIG, "joints_rad": JOINTS, "time_s": TIMES} | columns))


def test_a_stop_is_reached_from_the_one_before_it():
    moves = with_moves(stops()).move_rad

    assert moves == pytest.approx(np.array([NAN, NAN, (0.4, -0.5), (-0.1, 1.2)]), nan_ok=True)


def test_time_orders_the_stops_not_the_file():
    shuffled = np.array([3, 0, 2, 1])
    there = stops(config=CONFIG[shuffled], joints_rad=JOINTS[shuffled], time_s=TIMES[shuffled])

    moves = with_moves(there).move_rad

    assert moves == pytest.approx(with_moves(stops()).move_rad[shuffled], nan_ok=True)


def test_all_nests_of_a_stop_are_reached_by_the_same_move():
    moves = with_moves(stops(config=np.array([7, 8, 8, 9]))).move_rad

    assert moves[1] == pytest.approx(moves[2])


@pytest.mark.parametrize(
    "columns",
    [
        {"time_s": None},
        {"time_s": np.array([10.0, 12.0, np.nan, 50.0])},
        {"time_s": np.array([10.0, 12.0, 30.0, 30.0])},
        {"direction": np.ones((4, 2), dtype=int)},  # every joint from below, which it did not come from there
    ],
)
def test_where_the_stop_before_is_not_sure_no_move_is_told(columns):
    assert with_moves(stops(**columns)).move_rad is None


def test_directions_that_agree_and_unknown_ones_are_no_objection():
    direction = np.array([[1, 1], [1, 1], [1, -1], [0, 1]])

    moves = with_moves(stops(direction=direction)).move_rad

    assert np.isfinite(moves[2:]).all()


def test_one_move_in_a_hundred_from_elsewhere_is_unknown_alone():
    joints = np.random.default_rng(1).uniform(-1.0, 1.0, (120, 1))
    direction = np.sign(np.diff(joints, axis=0, prepend=0.0)).astype(int)
    direction[60] *= -1

    moves = with_moves(Stops(np.arange(120), joints, direction, np.arange(120.0))).move_rad

    assert np.flatnonzero(np.isnan(moves[:, 0])).tolist() == [0, 60]


def test_moves_that_are_known_stay():
    known = np.ones((4, 2))

    assert with_moves(stops(move_rad=known)).move_rad is known


def test_no_rows_have_no_moves():
    assert with_moves(Stops(np.zeros(0, dtype=int), np.zeros((0, 2)), time_s=np.zeros(0))).move_rad is None
