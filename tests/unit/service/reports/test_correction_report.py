"""The report of a corrected file."""

import numpy as np
import pytest

from tests.helpers.web.pages import Page
from truepose.domain.correction import CorrectedTargets, CorrectionTotals, FileCorrection
from truepose.reports.correction import CorrectionReport


def corrected(*statuses):
    n, done = len(statuses), np.array([status == "ok" for status in statuses])
    shift = np.where(done[:, None], 0.1, np.nan) * np.ones(3)
    counts = {status: statuses.count(status) for status in statuses}
    failed = tuple((f"p{row}", status) for row, status in enumerate(statuses) if status != "ok")
    totals = CorrectionTotals(counts, failed, 0.001, 0.011, 0.017, 0, 0.0, 0, 0.0, 0.0, zone_known=True)
    targets = CorrectedTargets(
        tuple(f"p{row}" for row in range(n)), statuses, np.arange(1, n + 1), np.full((n, 3), 100.0), shift,
        np.where(done, 0.017, np.nan), np.zeros(n), np.where(done, 0.001, np.nan),
    )  # fmt: skip
    return FileCorrection(totals, 0.2, (), 0, ()), targets


def page_of(*statuses):
    correction, targets = corrected(*statuses)
    report = CorrectionReport("weld.mod", "IRB 120", correction, targets, ("a" * 64, "b" * 64))
    return Page(report.page())


def test_a_whole_correction_says_so_with_its_largest_uncertainty_and_both_files():
    page = page_of("ok", "ok")

    for said in ("ALL TARGETS CORRECTED", "0.017 mm", "a" * 64, "b" * 64, "weld.mod"):
        assert said in page.text
    assert "figure" in page.tags


@pytest.mark.parametrize("statuses", [("ok", "joint_limit"), ("out_of_reach",)])
def test_what_was_not_corrected_is_said_first(statuses):
    page = page_of(*statuses)

    assert "NOT FULLY CORRECTED" in page.text
    assert ("figure" in page.tags) == ("ok" in statuses)
