"""Upper limits: how large a cause that was not found could still be."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_start, proposed
from truepose.diagnosis.alternatives import upper_limits_mm
from truepose.diagnosis.screening.candidates import pool_candidates

GAP = ("backlash", "joint 3")
WAVE = ("joint_harmonics", "joint 6", "wave_6_2_sin")


def limit(start, cause):
    pool = pool_candidates(start.fit, proposed(start.scene, *cause)[:1])
    return upper_limits_mm(pool.view(), (0,))[0]


def way_mm(start, cause, values):
    """RMS of what a candidate of these values does to the tool."""
    pool = pool_candidates(start.fit, proposed(start.scene, *cause)[:1])
    whitened = np.array(values) @ pool.products.columns
    # 0.015 mm and the scatter of the arm are the same for all readings, one nest a stop: a plain factor
    block = start.fit.blocks[0]
    sigma = float(np.sqrt(np.median(block.component_variance()) + block.scatter_mm**2))
    return sigma * float(np.linalg.norm(whitened)) / np.sqrt(len(block.weights))


@pytest.mark.parametrize("cause", [GAP, WAVE])
def test_more_readings_lower_the_limit(cause):
    few, many = (limit(make_start({}, n=n), cause) for n in (40, 160))

    assert many < few


def test_the_limit_holds_what_is_there_in_nearly_all_campaigns():
    starts = [make_start({"backlash": {"gap_3": 5e-5}}, n=40, seed=seed) for seed in range(8)]

    held = [limit(start, GAP) >= way_mm(start, GAP, [5e-5]) for start in starts]

    assert sum(held) >= 7  # of 8 at 95 %: fewer happen once in eighteen times, and seeds are fixed
