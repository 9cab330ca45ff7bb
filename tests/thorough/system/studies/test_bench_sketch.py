"""The sketch that truepose is timed beside does the work that it is timed for."""

import numpy as np
import pytest

from tests.studies.bench import arm


def test_the_sketch_finds_what_scipy_finds():
    seen = arm.readings(60)

    values, covariance = arm.identified(seen)

    # a tenth of a standard uncertainty: scipy stops at a relative change of the cost of 1e-8
    deviation = values - arm.by_differences(seen)
    assert np.abs(deviation / np.sqrt(np.diag(covariance))).max() < 0.1


def test_what_the_sketch_chooses_beats_what_is_drawn():
    rows = arm.candidate_rows(200)
    drawn = np.random.default_rng(0).choice(200, 20, replace=False)

    chosen = arm.chosen(rows, 20, np.random.default_rng(0))

    assert len(set(chosen)) == 20
    assert information(rows[chosen]) > information(rows[drawn]) + 1.0


@pytest.mark.parametrize("n", [1, 7])
def test_an_arm_without_errors_is_where_its_table_says(n):
    joints = np.zeros((n, 6))

    place = arm.predicted(np.zeros(6), arm.NOMINAL, np.zeros(3), joints)[0]

    # the flange of an IRB 120 at its zero position: 302 + 72 mm out, 290 + 270 + 70 mm up
    assert place == pytest.approx(np.tile([374.0, 0.0, 630.0], (n, 1)), abs=1e-9)


def information(members):
    flat = members.reshape(-1, members.shape[2])
    return np.linalg.slogdet(flat.T @ flat)[1]
