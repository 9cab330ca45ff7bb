"""The report of a diagnosis as a file in a browser."""

import pytest

from tests.helpers.diagnosis.diagnosed_cells import ENDINGS
from truepose.reports.diagnosis.report import DiagnosisReport

PHONE = {"width": 390, "height": 844}
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
def test_a_report_fits_tablet_and_phone_and_no_label_lies_on_another(tmp_path, reader, ending):
    path = tmp_path / "report.html"
    DiagnosisReport(ENDINGS[ending]()).write(path)

    reader.goto(path.as_uri())

    assert reader.evaluate("document.documentElement.scrollWidth") == 800
    # Letters below 9 px are no letters at arm's length.
    assert reader.evaluate(SMALLEST_LETTERS_PX) >= 9.0
    assert reader.evaluate(OVERLAPPING_LABELS) == []
    reader.set_viewport_size(PHONE)
    assert reader.evaluate("document.documentElement.scrollWidth") == PHONE["width"]
