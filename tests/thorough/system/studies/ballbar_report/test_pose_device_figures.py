"""The figures of the pose device against the thesis' table."""

import numpy as np

from tests.studies.ballbar_report import pose_device_figures
from tests.studies.ballbar_report.pose_device_figures import pose_device_section, simulated_sigma
from truepose.reports.table_report import Verdict


def test_every_figure_of_the_pose_device_is_that_of_the_table():
    # 4,000 draws leave a standard deviation uncertain by 1.1 %, 1 over the root of 8,000: 3 % is enough
    section = pose_device_section(4000, 1)

    assert {row.verdict for row in section.rows} == {Verdict.PASSED}
    assert [row.measured for row in section.rows[:3]] == ["144", "72", "54"]


def test_a_table_that_differs_in_its_last_digit_fails(monkeypatch):
    table = {"T1": (2.311,) * 4, "T2": (2.646, 2.646, 2.480, 2.480), "T3": (3.18, 3.05, 2.85, 3.18)}
    monkeypatch.setattr(pose_device_figures, "_TABLE", table)

    section = pose_device_section(4000, 1)

    failed = [row.figure for row in section.rows if row.verdict is Verdict.FAILED]
    assert [figure[:2] for figure in failed] == ["T1", "T3", "T3"]  # the printed T3 is off by 6 % when drawn


def test_the_same_seed_draws_the_same():
    first, second = (simulated_sigma(50, np.random.default_rng(3)) for _ in range(2))

    assert np.array_equal(first, second)
