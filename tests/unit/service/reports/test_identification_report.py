import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_identification, make_model, make_statistics
from tests.helpers.web.pages import HOSTILE, Page, assert_asks_nothing, assert_hostile_text_stays_text
from truepose.domain.campaign import LegReadings, ReadingName, ReadingsSetAside
from truepose.domain.cell import Artefact
from truepose.domain.identification import NominalAndIdentified, Outlier, PureError
from truepose.identification import identify, predict
from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.message import together
from truepose.reports.identification.report import DiagnosisLink, IdentificationReport
from truepose.reports.identification.summary import TrueParameter, Truth
from truepose.reports.traceability import Instrument, Period, ReportConditions

PAINTED_ELSEWHERE = pytest.mark.usefixtures("empty_pictures")


def report_of(tmp_path, identification, campaign, **parts):
    path = tmp_path / "out" / "report.html"
    IdentificationReport(identification, campaign, **parts).write(path)
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def plain_report(tmp_path_factory, identification, campaign):
    """A report with everything that is optional left out; drawing one takes a second."""
    return report_of(tmp_path_factory.mktemp("plain"), identification, campaign)


UNFITTED = make_identification(
    model=None, message="Only 3 configurations.", calibration=None, cross_validation=None, parameters=()
)  # has no pictures and is quick to write: for tests of what stands beside them


def test_a_plain_campaign_gives_a_complete_report(plain_report):
    page = Page(plain_report)

    for heading in (
        "Errors before and after",
        "Contribution of the instrument to the measured error",
        "Directions of the errors",
        "Residuals against joint angles",
        "Uncertainty of the headline figures",
        "Outliers",
        "Repeatability and lack of fit",
        "Parameters",
        "Not determined by these data",
        "Conditions",
        "Method",
    ):
        assert heading in page.text
    assert sum(tag == "svg" for tag, _ in page.elements) == 9  # two of them on the first page
    assert "truepose 0." in page.text


def test_the_file_asks_nothing_from_anywhere(plain_report):
    assert_asks_nothing(plain_report, pixels=True)
    assert len(plain_report) < 6_000_000


def test_a_diagnosis_of_the_same_readings_stands_in_one_line_with_its_report(tmp_path, campaign):
    link = DiagnosisLink("diagnosis.html", f"Joint 6 has a wave. {HOSTILE}")

    page = Page(report_of(tmp_path, UNFITTED, campaign, diagnosis=link))

    assert ("a", "diagnosis.html") in {(tag, attributes.get("href")) for tag, attributes in page.elements}
    assert "Diagnosis: Joint 6 has a wave." in page.text
    assert "script" not in page.tags


@PAINTED_ELSEWHERE
def test_text_of_users_stays_text(tmp_path, identification, campaign):
    hostile = replace(
        campaign,
        robot=replace(campaign.robot, name=HOSTILE, source=HOSTILE),
        notes=(HOSTILE,),
        ignored=(HOSTILE,),
    )
    conditions = ReportConditions(
        instruments=(Instrument(HOSTILE, HOSTILE, HOSTILE, HOSTILE, HOSTILE, HOSTILE),),
        artefacts=(Artefact(HOSTILE, HOSTILE, HOSTILE),),
        robot_serial_number=HOSTILE,
        person=HOSTILE,
        load=HOSTILE,
        sessions=(Period(HOSTILE, HOSTILE, HOSTILE),),
        notes=(HOSTILE,),
    )
    truth = Truth((TrueParameter(HOSTILE, 1.0, 1.0, 0.1, HOSTILE),), ((HOSTILE, make_statistics()),))
    said = replace(identification, message=HOSTILE, outliers=(Outlier(0, 1, 1, 0.5, HOSTILE),))

    page = Page(report_of(tmp_path, said, hostile, conditions=conditions, truth=truth))

    assert_hostile_text_stays_text(page)


def test_whatever_nobody_stated_is_shown_as_not_stated(plain_report):
    text = Page(plain_report).text

    for name in (
        "Robot serial number:",
        "Measured by:",
        "Written:",
        "Load",
        "Warm-up",
        "Approach",
        "Sessions",
    ):
        assert f"{name} not stated" in text
    assert "Instruments: not stated." in text
    assert "scale not verified" in text
    assert "SIMULATED" not in text


def test_stated_conditions_stand_in_the_report(tmp_path, campaign):
    conditions = ReportConditions(
        instruments=(Instrument("laser tracker", "Leica", "AT960", "750123", "3.2", "No. 2031, 2026-03-01"),),
        settle_s=4.0,
        scale=1.000002,
        scale_standard_uncertainty=1.5e-6,
        sessions=(Period("calibration", "09:00", "10:10"),),
    )

    text = Page(report_of(tmp_path, UNFITTED, campaign, conditions=conditions)).text

    assert "laser tracker Leica AT960 750123 3.2 No. 2031, 2026-03-01" in text
    assert "Settling time before a reading 4 s" in text
    assert "certified over measured length is 1 + 2e-06, u = 1.5e-06" in text
    assert "Session calibration 09:00 to 10:10" in text


@pytest.mark.parametrize("source", ["conditions", "campaign"])
def test_a_simulated_measurement_says_so_before_anything_else(tmp_path, campaign, source):
    conditions = ReportConditions(simulated=source == "conditions")
    measured = replace(campaign, simulated=source == "campaign")

    html = report_of(tmp_path, UNFITTED, measured, conditions=conditions)

    assert 0 < html.index("SIMULATED.") < html.index("<h1>")


@PAINTED_ELSEWHERE
def test_without_held_out_readings_the_report_warns_that_its_pictures_flatter(
    tmp_path, campaign_without_validation
):
    identification = identify(campaign_without_validation, ("base", "geometry"))

    text = Page(report_of(tmp_path, identification, campaign_without_validation)).text

    assert (
        "The plots show the readings used to identify the model, so the model looks better than it is" in text
    )
    assert "Cross-validation" in text
    assert "each predicted by a model fitted without its configuration" in text


def test_an_identification_without_a_model_says_why_and_shows_no_picture(tmp_path, campaign):
    page = Page(report_of(tmp_path, UNFITTED, campaign))

    assert "Only 3 configurations." in page.text
    assert "figure" not in page.tags
    assert "Conditions" in page.text


@PAINTED_ELSEWHERE
@pytest.mark.parametrize("fitted", [True, False])
def test_what_was_set_aside_is_said_once_on_the_cover_and_once_inside(identification, campaign, fitted):
    aside = ReadingsSetAside((ReadingName(8, 1),), "it slipped", "Ada Byron", rows=(7,))
    found = identification if fitted else UNFITTED
    without = replace(found, message=together(found.message, aside.sentence), set_aside=aside)

    described = IdentificationReport(without, campaign).described(IN_ENGLISH)

    for sentence in (described.front.sentence, described.filled_in["headline"].sentence):
        assert sentence.count("1 reading set aside by Ada Byron: it slipped.") == 1


def test_outliers_stand_with_their_reason_and_figures_with_and_without(tmp_path, identification, campaign):
    spoilt = campaign.calibration.position_mm.copy()
    spoilt[7, 2] += 5.0
    gross = replace(campaign, calibration=replace(campaign.calibration, position_mm=spoilt))

    text = Page(report_of(tmp_path, identify(gross, ("base", "geometry")), gross)).text

    assert "Calibration, without outliers without the outliers given zero weight (1)" in text
    assert "no reading is deleted" in text
    # Row, configuration, nest and a residual of 5 mm but for noise (0.01 mm) and what the others pull (less).
    assert re.search(r"\b8 8 1 (4\.9[5-9]|5\.0[0-5])\d* off by", text)


@pytest.mark.parametrize(
    ("p_value", "said"),
    [
        (0.4, "explains the readings to within their repeatability"),
        (1e-9, "p < 0.0001: the model does not explain the readings to within"),
    ],
)
def test_revisits_tell_repeatability_and_lack_of_fit(tmp_path, campaign, p_value, said):
    pure = PureError(12, 36, 0.0123, 1.1, p_value)

    text = Page(report_of(tmp_path, replace(UNFITTED, pure_error=pure), campaign)).text

    assert "12 readings of configurations measured before (36 degrees of freedom)" in text
    assert "0.0123 mm standard deviation per axis" in text
    assert said in text


def test_true_values_stand_beside_the_identified_ones(tmp_path, campaign):
    truth = Truth(
        (TrueParameter("a_3", 0.21, 0.2, 0.01, "mm"), TrueParameter("d_2", 0.5, 0.2, 0.01, "mm")),
        (("after best rigid alignment", make_statistics(mean_mm=0.0123)),),
    )

    text = Page(report_of(tmp_path, UNFITTED, campaign, truth=truth)).text

    assert "1 of 2 true parameters lie within the stated 95 % interval" in text
    assert "after best rigid alignment 10 0.0123" in text
    assert "a_3 0.210 0.200 0.010 mm +1.0" in text


@PAINTED_ELSEWHERE
def test_lengths_are_reported_as_lengths(tmp_path, campaign):
    points = campaign.calibration
    foot = np.array([250.0, -400.0, 900.0])
    legs = [_legs_from(foot, points.stops), _legs_from(foot, campaign.validation.stops)]
    ballbar = replace(campaign, calibration=None, validation=None, legs=legs[0], validation_legs=legs[1])

    text = Page(report_of(tmp_path, identify(ballbar, ("geometry",)), ballbar)).text

    assert "Mean length error " in text
    assert "Assessed on 60 held-out lengths" in text
    assert "Absolute length errors [mm]" in text
    assert "drawn along the ballbar" in text
    assert "lengths need no world frame" in text


def _legs_from(foot_mm, stops):
    one = np.ones(len(stops), np.int64)
    position, _ = predict(make_model(), stops, one)
    length = np.linalg.norm(position - foot_mm, axis=1)
    return LegReadings(stops, one, one, one, length, np.full(len(stops), 0.001))


@PAINTED_ELSEWHERE
def test_the_same_data_give_the_same_file(tmp_path, identification, campaign):
    first, second = (report_of(tmp_path, identification, campaign) for _ in range(2))

    assert first == second


@PAINTED_ELSEWHERE
def test_captions_name_the_lines_that_are_drawn_and_no_others(
    tmp_path, plain_report, identification, campaign
):
    points = campaign.validation
    silent = replace(points, standard_uncertainty_mm=np.zeros(60))
    still = replace(silent, stops=replace(points.stops, joints_rad=np.zeros((60, 3))))
    quiet = NominalAndIdentified(make_statistics(noise_mm=0.0), make_statistics(noise_mm=0.0))

    bare = report_of(tmp_path, replace(identification, validation=quiet), replace(campaign, validation=still))

    for words in ("Dashed: ", "Lines: moving average", "Grey: ± 2 u"):
        assert words in plain_report
        assert words not in bare


def test_marks_of_parameters_are_explained_where_they_stand_and_nowhere_else(plain_report):
    rows = plain_report.split("Description</th>")[1]

    for mark in ("prior", "combined"):
        explained = f'<span class="mark warn">{mark}</span> ' in plain_report.split("Description</th>")[0]
        assert explained is (f'<span class="mark warn">{mark}</span></th>' in rows)


def test_no_table_with_and_without_outliers_is_promised_where_there_is_none(plain_report):
    assert "None: every reading counts." in plain_report
    assert "figures with and without" not in plain_report
