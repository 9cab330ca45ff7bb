"""Rows of a table: of every column that is there, those of the tables within it too."""

import numpy as np

from truepose.domain.campaign import PointReadings, Stops

STOPS = Stops(np.array([5, 6, 7]), np.arange(6.0).reshape(3, 2), time_s=np.array([0.0, 1.0, 2.0]))
POINTS = PointReadings(STOPS, np.array([1, 2, 3]), np.arange(9.0).reshape(3, 3), np.full(3, 0.01))


def test_taking_rows_takes_them_from_every_column_that_is_there():
    chosen = STOPS.taken(np.array([2, 0]))

    assert chosen.config.tolist() == [7, 5]
    assert chosen.time_s.tolist() == [2.0, 0.0]
    assert chosen.joints_rad.tolist() == [[4.0, 5.0], [0.0, 1.0]]
    assert chosen.torque_n_mm is None


def test_a_table_within_a_table_gives_the_same_rows():
    chosen = POINTS.taken(np.array([1, 1]))

    assert len(chosen) == 2
    assert chosen.stops.config.tolist() == [6, 6]
    assert chosen.nest.tolist() == [2, 2]
    assert chosen.position_mm.tolist() == [[3.0, 4.0, 5.0]] * 2
    assert chosen.quaternion is None


def test_no_row_is_an_empty_table():
    assert len(POINTS.taken(np.zeros(0, dtype=np.int64))) == 0
