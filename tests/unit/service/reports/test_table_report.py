import pytest

from truepose.reports.table_report import Row, Section, Verdict, verdict_sentence, write_table_report


def section(*verdicts):
    return Section("tilted", tuple(Row("mean", "<= 0.032 mm", "0.0301 mm", verdict) for verdict in verdicts))


@pytest.mark.parametrize(
    ("verdicts", "sentence"),
    [
        ((Verdict.PASSED, Verdict.PASSED, Verdict.NO_TARGET), "All 2 figures meet their targets."),
        (
            (Verdict.PASSED, Verdict.FAILED, Verdict.NOT_MEASURED),
            "Of 3 figures with a target: 1 failed, 1 not measured.",
        ),
        ((Verdict.NO_TARGET,), "No figure has a target."),
        ((), "No figure has a target."),
    ],
)
def test_the_sentence_counts_what_was_reached(verdicts, sentence):
    assert verdict_sentence([section(*verdicts)]) == sentence


@pytest.mark.parametrize(
    ("verdict", "good"),
    [
        (Verdict.PASSED, True),
        (Verdict.NOT_MEASURED, False),
        (Verdict.FAILED, False),
        (Verdict.NO_TARGET, False),
    ],
)
def test_only_figures_that_all_passed_look_good(tmp_path, verdict, good):
    path = tmp_path / "night" / "report.html"

    write_table_report(path, "Night run", [section(verdict)], simulated=True, written_at="2026-11-21")

    html = path.read_text(encoding="utf-8")
    assert ('class="headline bad"' not in html) is good
    assert "SIMULATED" in html
    assert "Written: 2026-11-21" in html
    assert verdict.value in html


def test_text_stays_text(tmp_path):
    hostile = "<script>alert(1)</script>"
    path = tmp_path / "report.html"

    write_table_report(
        path, hostile, [Section(hostile, (Row(hostile, hostile, hostile, Verdict.FAILED),), hostile)]
    )

    html = path.read_text(encoding="utf-8")
    assert "<script" not in html
    assert "&lt;= 0" not in html
    assert html.count("&lt;script&gt;") == 7  # title, heading, section, note and three cells
