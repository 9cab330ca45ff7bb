"""The report of a diagnosis as a file in a browser."""

import pytest

from tests.helpers.diagnosis.diagnosed_cells import ENDINGS, two_findings
from truepose.reports.diagnosis.report import DiagnosisReport

SMALLEST_LETTERS_PX = """Math.min(16, ...[...document.querySelectorAll("svg text")].map(
    (text) => text.getBoundingClientRect().height))"""
OVERLAPPING_LABELS = """(() => {
  const found = [];
  for (const svg of document.querySelectorAll("figure svg")) {
    const labels = [...svg.querySelectorAll("text")];
    const boxes = labels.map((text) => [text.textContent, text.getBoundingClientRect()]);
    boxes.forEach(([first, a], i) => boxes.slice(i + 1).forEach(([second, b]) => {
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 1 && down > 2) found.push(`${first} / ${second}`);
    }));
  }
  return found;
})()"""


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_report_fits_a_tablet_and_no_label_lies_on_another(tmp_path, reader, ending):
    path = tmp_path / "report.html"
    DiagnosisReport(ENDINGS[ending]()).write(path)

    reader.goto(path.as_uri())

    assert reader.evaluate("document.documentElement.scrollWidth") == 800
    # Letters below 9 px are no letters at arm's length.
    assert reader.evaluate(SMALLEST_LETTERS_PX) >= 9.0
    assert reader.evaluate(OVERLAPPING_LABELS) == []


def test_a_report_on_a_phone_does_not_scroll_sideways(tmp_path, reader):
    path = tmp_path / "report.html"
    DiagnosisReport(two_findings()).write(path)
    reader.set_viewport_size({"width": 390, "height": 844})

    reader.goto(path.as_uri())

    assert reader.evaluate("document.documentElement.scrollWidth") == 390
