"""The report of a validation: verdict, places, distances, ISO 9283 with what it does not prove."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.lost_visit import MODEL, planned_poses, readings_of_model
from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS
from tests.helpers.printed import printed
from tests.helpers.web.pages import Page
from truepose.domain.campaign import PointReadings, Stops
from truepose.exchange.results.validation import accuracy_document, pose_test_document
from truepose.identification import judge
from truepose.kinematics.chain import nominal_chain
from truepose.reports.pose_test import pose_test_summary, pose_test_table
from truepose.reports.rounding import format_rounded, millimetres, uncertainty
from truepose.reports.traceability import Audit, Instrument, ReportConditions
from truepose.reports.validation import ValidationReport, deciding_budget, validation_summary
from truepose.validation.iso9283.pose_test import pose_test
from truepose.validation.validate import validate

PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")


@pytest.fixture(scope="module")
def points():
    """Thirty cycles, of which one visit of P3 was lost, and twenty other configurations."""
    read = readings_of_model(scatter_mm=0.003)
    return replace(read, stops=replace(read.stops, temperature_c=np.linspace(20.0, 22.5, len(read))))


def written(tmp_path, points, limit_mm=None, **more):
    found = ValidationReport(validate(MODEL, points, limit_mm=limit_mm), MODEL, points, **more)
    found.write(tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text("utf-8")
    return page, " ".join(re.sub(r"<svg.*?</svg>|<style.*?</style>|<[^>]+>", " ", page, flags=re.S).split())


def test_the_report_says_verdict_places_and_distances(tmp_path, points):
    page, text = written(tmp_path, points)

    assert text.startswith("Validation of ABB IRB 120")
    assert "consistent with the predicted accuracy" in text
    assert re.search(r"Measured minus predicted distance, all 14,196 pairs", text)
    assert "The calibration readings lie within" in text
    assert "front/up" in text
    assert page.count("<svg") == 5  # verdict and bars of the first page, and three figures
    assert "ISO 9283" not in text


@PAINTED_ELSEWHERE
def test_the_report_of_a_test_has_figures_conditions_and_what_they_do_not_prove(tmp_path, points):
    conditions = ReportConditions(
        load="2.6 kg",
        warm_up="an hour",
        tool_speed_mm_s=500.0,
        instruments=(Instrument("tracker", model="T-1"),),
    )

    _, text = written(tmp_path, points, pose_test=pose_test(MODEL, points), conditions=conditions)

    assert "Five poses do not prove accuracy in a workspace" in text
    assert "over 20 readings in other configurations its error is 0.05" in text
    assert "AP of P3: P3 was measured in 29 cycles (cycle 3 is missing)" in text
    for stated in ("2.6 kg", "an hour", "500 mm/s", "T-1", "5 poses, 30 cycles", "20.0 to 22.5", "7.2.2"):
        assert stated in text


AUDIT = Audit(7, "5e" * 32, "/api/v1/sessions/7/accuracy?model_id=3", "d0" * 32, 3, "0d" * 32)


def content(points, **more):
    found = ValidationReport(validate(MODEL, points), MODEL, points, audit=AUDIT, **more)
    return Page(re.sub("<svg.*?</svg>", "", found.content(), flags=re.DOTALL)).text


@PAINTED_ELSEWHERE
def test_the_page_of_a_test_leads_with_its_worst_figures_and_what_they_do_not_prove(points):
    text = content(points, pose_test=pose_test(MODEL, points))

    first = text[: text.index("Errors before and after")]
    assert text.startswith("ISO 9283 test of ABB IRB 120")
    assert "AP, worst pose 0.05" in first
    assert re.search(r"Largest error in the workspace 0\.05\d\d? mm at 20 other configurations", first)
    assert "RP, worst pose" in first
    assert re.search(r"Commanded poses \[mm\] P1 \(\d+ -?\d+ \d+\), P2", text)
    for hash in ("5e" * 32, "0d" * 32, "d0" * 32):
        assert hash in text


@PAINTED_ELSEWHERE
def test_where_nothing_else_was_measured_the_page_sets_the_claim_beside(points):
    text = content(points, pose_test=replace(pose_test(MODEL, points), work_space=None))

    assert "predicted by the model; no other configuration was measured" in text
    assert "Largest error in the workspace" not in text


@PAINTED_ELSEWHERE
def test_the_page_and_the_document_state_the_same_numbers(points):
    test = pose_test(MODEL, points)
    page, told = content(points, pose_test=test), accuracy_document(validate(MODEL, points), test)

    for figure in told.iso9283.figures:
        half = "±" if figure.symbol == "RD" or (figure.symbol == "RP" and figure.component != "l") else ""
        value = f"{half}{format_rounded(figure.value, figure.standard_uncertainty)}"
        assert f"{value} {uncertainty(figure.standard_uncertainty)} {figure.unit}" in page
    for pair in (told.position, told.relative, told.distance):
        for one in (pair.nominal, pair.identified):
            sizes = (one.mean_mm, one.rms_mm, one.sd_mm, one.max_mm)
            assert " ".join([f"{one.n:,}", *map(millimetres, sizes)]) in page


@PAINTED_ELSEWHERE
def test_what_nobody_said_is_not_stated(tmp_path, points):
    _, text = written(tmp_path, points, pose_test=pose_test(MODEL, points))

    assert "Measuring instrument not stated" in text
    assert "Load not stated" in text


@PAINTED_ELSEWHERE
@pytest.mark.parametrize(
    ("limit_mm", "sentence"),
    [
        (0.2, "the robot conforms"),
        (0.05, "the robot does not conform"),
        (0.06, "conformity cannot be decided: the readings are too uncertain"),
    ],
)
def test_the_decision_is_said(tmp_path, points, limit_mm, sentence):
    doubtful = replace(points, standard_uncertainty_mm=np.where(np.arange(len(points)) == 7, 0.02, 0.0001))

    _, text = written(tmp_path, doubtful, limit_mm)

    assert sentence in text
    assert "ISO 14253-1" in text


def test_figures_are_printed_to_the_digits_of_their_uncertainty(points):
    shown = pose_test_table(pose_test(MODEL, points)).of_columns(0, 2, 3, 4, 6, 7)
    rows = {(name, pose, by): (value, unit, noise) for name, pose, by, value, unit, noise in shown.rows}

    value, unit, noise = rows["AP p", "P1", "identified"]
    assert re.fullmatch(r"0\.05\d\d", value)
    assert (unit, noise) == ("mm", "")
    assert rows["AP x", "P1", "nominal"][0].startswith("-0.9")
    assert rows["RP l", "P1", ""][2]
    assert rows["RD p", "P2-P4", ""][0].startswith("±")
    assert ("RP l", "P3", "") not in rows


def test_the_document_has_every_figure_once(points):
    document = pose_test_document(pose_test(MODEL, points))

    keys = [(f["symbol"], f["component"], f["subject"], f["commanded_by"]) for f in document["figures"]]
    assert len(keys) == len(set(keys)) == 2 * (4 * 4 + 4) + 4 + 4  # AP and AD of both models, RP, RD
    assert {w["subject"] for w in document["withheld"]} == {"P3"}
    assert document["work_space"]["identified"]["n"] == 20
    assert document["sentence"].startswith("Five poses do not prove")
    assert set(document["figures"][0]) == {
        "symbol",
        "component",
        "subject",
        "commanded_by",
        "value",
        "standard_uncertainty",
        "unit",
        "visits",
        "noise",
        "clause",
    }


def test_the_terminal_says_the_same(points):
    found = validate(MODEL, points, limit_mm=0.2, rule="simple")

    text = " ".join(printed(validation_summary(found), pose_test_summary(pose_test(MODEL, points))).split())

    assert "Simple acceptance: the robot conforms. The uncertainty is not taken into account." in text
    assert "Withheld: AP of P3: P3 was measured in 29 cycles" in text
    assert "Five poses do not prove accuracy" in text


@PAINTED_ELSEWHERE
def test_the_conditions_name_the_cube_and_the_share_of_the_rated_speed(tmp_path, points):
    test = pose_test(MODEL, points)

    _, text = written(tmp_path, points, pose_test=test, conditions=ReportConditions(speed_percent=50.0))

    assert "Test cube edge 150 mm, centre (300 0 250) in the measurement frame" in text
    assert "Fraction of rated speed 50 %" in text
    assert "Drift from cold" not in text


def warming(hours):
    """P1 ten times a group, every half hour; it goes 0.1 mm upwards and stops after an hour."""
    group = np.repeat(np.arange(int(2 * hours) + 1), 10)
    n = len(group)
    joints = np.tile(planned_poses().joints_rad[0], (n, 1))
    seen = nominal_chain(IRB_120, joints).points(np.array(NESTS[0]))
    seen += 0.001 * np.random.default_rng(6).standard_normal(seen.shape)
    seen[:, 2] += 0.05 * np.minimum(group, 2)
    stops = Stops(
        np.ones(n, dtype=np.int64),
        joints,
        group=group,
        time_s=1800.0 * group + np.tile(np.arange(10.0), n // 10),
    )
    return PointReadings(stops, np.ones(n, dtype=np.int64), seen, np.full(n, 0.002))


@pytest.mark.parametrize(
    ("hours", "said", "withheld"),
    [(4, "is below a tenth of that over the first", False), (1, "The robot may drift further", True)],
)
def test_a_test_of_drift_is_drawn_with_what_its_hours_tell(tmp_path, hours, said, withheld):
    seen = warming(hours)
    test = pose_test(MODEL, seen)

    page, text = written(tmp_path, seen, pose_test=test)

    assert "displacement of the barycentre" in page
    assert re.search(r"The mean position moved by up to 0\.(099|100|101)\d* mm \(u 0\.000\d+ mm\)", text)
    assert said in text
    assert ("ISO 9283 requires 8 h of work from cold" in text) == withheld
    assert f"one pose, {20 * hours + 10} visits in {2 * hours + 1} groups" in text
    document = pose_test_document(test)["drift"]
    assert (len(document["curve"]), document["settled"]) == (2 * hours + 1, not withheld)


def budget_of(points, **how):
    found = validate(MODEL, points, **how)
    judged = judge(MODEL, points, MODEL.repeatability_mm)
    return found, deciding_budget(judged, MODEL, found.decision, ReportConditions())


def test_the_budget_of_a_decision_is_what_its_guard_band_is_made_of(points):
    found, budget = budget_of(points, limit_mm=0.2)

    assert budget.guard_mm == found.decision.guard_mm == pytest.approx(1.65 * budget.combined_mm)
    assert sum(part.share or 0.0 for part in budget.parts) == pytest.approx(1.0)
    assert [part.u_mm is None for part in budget.parts] == [False, False, True, True, True]


def test_without_a_limit_the_budget_is_of_the_largest_error_and_has_no_guard_band(points):
    found, budget = budget_of(points)

    assert budget.guard_mm is None
    assert budget.combined_mm == pytest.approx(found.uncertainty.position.identified.max_mm, abs=1e-8)
    assert budget_of(points, limit_mm=0.2, rule="simple")[1].guard_mm is None


@PAINTED_ELSEWHERE
def test_the_budget_of_the_decision_is_printed(tmp_path, points):
    found, budget = budget_of(points, limit_mm=0.2)
    path = tmp_path / "report.html"
    ValidationReport(found, MODEL, points).write(path)

    text = Page(path.read_text(encoding="utf-8")).text

    assert "Uncertainty budget of the decision" in text
    assert uncertainty(budget.guard_mm) in text
