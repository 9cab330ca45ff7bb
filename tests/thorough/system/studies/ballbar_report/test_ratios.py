"""Ratios over robots, and the rows that show them."""

import math

import pytest

from tests.studies.ballbar_report.ratios import ratio_of, ratio_row
from truepose.reports.table_report import Verdict


def test_every_robot_counts_the_same_however_bad_it_is():
    found = ratio_of([(1.0, 2.0), (30.0, 20.0)])

    assert found.mean == pytest.approx(1.0)
    assert found.of_means == pytest.approx(31.0 / 22.0)
    assert found.standard_error == pytest.approx(0.5)  # standard deviation sqrt(0.5) over sqrt(2)
    assert found.robots == 2


def test_one_robot_has_no_standard_error():
    assert math.isnan(ratio_of([(1.0, 2.0)]).standard_error)


@pytest.mark.parametrize(("limit", "verdict"), [(1.0, Verdict.PASSED), (0.99, Verdict.FAILED)])
def test_the_mean_over_robots_is_what_must_reach_the_target(limit, verdict):
    row = ratio_row("ballbar over tracker", ratio_of([(1.0, 2.0), (30.0, 20.0)]), limit)

    assert row.verdict is verdict
    assert row.measured == "1.000 ± 0.500 (ratio of the means 1.409; 2 robots)"


def test_without_any_robot_a_target_was_not_measured():
    assert ratio_row("over thesis", ratio_of([]), 0.35).verdict is Verdict.NOT_MEASURED
    assert ratio_row("over thesis", ratio_of([])).verdict is Verdict.NO_TARGET
