"""Bad readings that fall anywhere: how often chance alone makes them share something."""

import numpy as np

from tests.helpers.diagnosis.point_scenes import telling_campaign, telling_scene
from truepose.diagnosis.reading_faults import shared_properties

N = 96


def test_readings_that_are_bad_anywhere_share_nothing_more_often_than_is_said():
    scene = telling_scene(campaign=telling_campaign(N))
    rng = np.random.default_rng(1)
    drawn = [np.isin(np.arange(N), rng.choice(N, size, replace=False)) for size in [3, 6, 12, 24] * 100]

    assert sum(shared_properties(scene, bad) is not None for bad in drawn) <= 8  # 4 of 400 at 1 %
