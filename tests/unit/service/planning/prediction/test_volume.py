"""The work volume: ranges and box are kept to, and a volume without the arm is refused."""

import numpy as np
import pytest

from tests.unit.service.planning.test_candidates import SPACE
from truepose.domain.robot import JointRange
from truepose.planning.errors import WorkSpaceError
from truepose.planning.prediction.plan import WorkVolume, sample
from truepose.planning.workspace.space import is_clear, nest_places, nominal_chain


def drawn(volume, n=100):
    return sample(SPACE, volume, n, np.random.default_rng(3))


def places(found):
    each = nest_places(SPACE, nominal_chain(SPACE, found.joints_rad))
    return each[found.nest - 1, np.arange(len(found))]


def test_without_more_words_it_is_the_calibration_ranges_with_every_nest():
    found = drawn(WorkVolume())

    assert len(found) == 3 * 100
    assert set(found.nest.tolist()) == {1, 2, 3}
    assert is_clear(SPACE, nominal_chain(SPACE, found.joints_rad)).all()


def test_nests_are_within_the_box():
    box = ((300.0, 600.0), (-200.0, 200.0), (200.0, 500.0))

    inside = places(drawn(WorkVolume(box_mm=box)))

    low, high = np.array(box).T
    assert len(inside) >= 100
    assert np.all((inside >= low) & (inside <= high))


def test_joints_are_within_ranges_of_their_own():
    narrow = tuple(JointRange(-0.1, 0.1) for _ in range(6))

    found = drawn(WorkVolume(ranges=narrow))

    assert np.abs(found.joints_rad).max() <= 0.1


def test_a_box_out_of_reach_is_refused():
    with pytest.raises(WorkSpaceError, match="box"):
        drawn(WorkVolume(box_mm=((5000.0, 5100.0), (0.0, 100.0), (0.0, 100.0))))
