"""Every stop for every nest, and which configurations are the same place."""

import numpy as np
import pytest

from truepose.domain.campaign import Stops, each_nest, sites

STOPS = Stops(np.array([5, 6, 7]), np.arange(6.0).reshape(3, 2), time_s=np.array([0.0, 1.0, 2.0]))


def revisits(config, repeat_of):
    return sites(Stops(np.array(config), np.zeros((len(config), 1)), repeat_of=np.array(repeat_of))).tolist()


def test_each_nest_keeps_the_stops_in_their_order():
    stops, nest = each_nest(STOPS, np.array([1, 3]))

    assert stops.config.tolist() == [5, 5, 6, 6, 7, 7]
    assert nest.tolist() == [1, 3, 1, 3, 1, 3]


@pytest.mark.parametrize(
    ("repeat_of", "found"),
    [
        ([-1, -1, -1, -1], [1, 2, 3, 4]),
        ([-1, -1, 1, 2], [1, 2, 1, 2]),
        ([-1, -1, 1, 3], [1, 2, 1, 1]),  # a revisit of a revisit
        ([-1, 99, 99, -1], [1, 99, 99, 4]),  # the first visit is not among these rows
        ([1, -1, -1, -1], [1, 2, 3, 4]),  # its own revisit
        ([2, 3, 2, -1], [2, 2, 2, 4]),  # a circle, and one that leads into it
    ],
    ids=["none", "two", "chain", "absent", "self", "circle"],
)
def test_a_revisit_counts_as_the_configuration_it_revisits(repeat_of, found):
    assert revisits([1, 2, 3, 4], repeat_of) == found


def test_without_the_column_every_configuration_is_its_own():
    assert sites(STOPS).tolist() == [5, 6, 7]
