import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import make_described, make_rest
from tests.helpers.diagnosis.diagnosed_cells import (
    ENDINGS,
    NOTHING_LEFT,
    make_curve,
    make_diagnosis,
    make_errors,
    make_finding,
    make_gain_finding,
    two_findings,
)
from tests.helpers.domain.builders import make_model
from tests.helpers.web.pages import (
    HOSTILE,
    Page,
    assert_asks_nothing,
    assert_hostile_text_stays_text,
    leave_pictures_empty,
)
from truepose.domain.diagnosis import Cause, Detail, NextMeasurement, RuledOut
from truepose.reports.diagnosis.report import DiagnosisReport
from truepose.reports.traceability import ReportConditions


def page_of(diagnosis, **parts):
    return Page(DiagnosisReport(diagnosis, **parts).content())


# Each kind of picture is in one of these; painting those of a page takes half a second.
PAINTED = ("two findings", "several waves", "described", "partly explained", "lengths")


@pytest.fixture(scope="module")
def pages():
    """The report of each ending as a file, pictures put together and those of some painted."""
    made = {}
    for name, ending in ENDINGS.items():
        with pytest.MonkeyPatch.context() as patch:
            if name not in PAINTED:
                leave_pictures_empty(patch)
            made[name] = str(DiagnosisReport(ending()).content())
    return made


def plain(**changes):
    """A diagnosis without pictures, quick to write: for tests of the words."""
    finding = make_finding(curve=None)
    return make_diagnosis(**{"findings": (finding,), "errors": None, **changes})


@pytest.mark.parametrize("name", ENDINGS)
def test_every_ending_gives_a_page_that_asks_nothing_from_anywhere(pages, name):
    html = pages[name]

    assert_asks_nothing(html)
    assert not re.search(r"\bnan\b|\bNone\b(?!: no known cause)", Page(html).text)


def test_the_map_stands_above_the_findings_with_a_table_for_those_who_cannot_see_it(pages):
    html = pages["described"]

    shown = html[html.index('id="map"') : html.index('id="findings"')]
    assert 'aria-label="Map of the error sources' in shown
    assert "<th>Joint 9</th><td>angle of joint 10</td>" in shown
    assert shown.count("<td>modelled empirically</td>") == 9
    assert "a dotted line" not in shown.lower()
    assert 'id="map"' not in pages["consistent"]


def test_a_model_that_only_describes_is_not_called_the_start_model():
    page = page_of(make_diagnosis(findings=(), remaining=make_rest(make_described())))

    assert "with empirical terms" in page.text
    assert "nothing was added" not in page.text
    assert "the same model" not in page.text


def test_several_waves_are_a_picture_and_a_row_each(pages):
    html = pages["several waves"]

    assert 'aria-label="Amplitude of each harmonic against its order"' in html
    assert "<th>Order 2</th><td>amplitude 0.0290 ± 0.0020 deg " in html
    assert "Amplitude of each harmonic" not in pages["explained"]
    assert "<th>Order</th><td>2 " in pages["explained"]


def test_small_findings_stand_folded_below_the_findings_under_their_own_heading(pages):
    html = pages["small findings"]

    below = html[html.index('id="small"') : html.index('id="before-after"')]
    assert "<summary>Joint 2 turns 0.021 % further than it should.</summary>" in below
    assert 'id="finding-2"' in below
    assert "gain_2" in html[html.index('id="model"') :]
    assert "<dd>1<small>1 certain, 0 likely; 1 small</small></dd>" in html
    assert 'id="small"' not in pages["two findings"]


def test_what_is_described_without_a_name_stands_under_what_is_left(pages):
    html = pages["described"]

    left = html[html.index('id="left"') : html.index('id="ruled-out"')]
    assert "Modelled empirically" in left
    assert (
        left.count("as a function of angle of joint") == 8 + 3
    )  # a row each, and the largest in the sentence
    assert "Smaller terms not listed: 1." in left
    assert "Modelled empirically" not in pages["partly explained"]


@pytest.mark.parametrize("name", ENDINGS)
def test_the_first_sentence_after_the_title_is_the_message(pages, name):
    diagnosis, html = ENDINGS[name](), pages[name]

    first = re.search(r'class="message">(.*?)</p>', html)
    assert first[1] == diagnosis.message.replace("'", "&#39;")
    assert html.index('class="message"') < html.index("<h2")


@pytest.mark.parametrize(
    ("ending", "word", "look"),
    [
        ("consistent", "Consistent.", "consistent"),
        ("explained", "Explained.", "explained"),
        ("partly explained", "Partly explained.", "partly_explained"),
        ("unexplained", "Unexplained.", "unexplained"),
        ("nothing fitted", "No result.", "not_answered"),
    ],
)
def test_a_verdict_is_a_word_and_a_shape_and_a_colour(pages, ending, word, look):
    page = Page(pages[ending])

    assert word in page.text
    assert {"class": f"verdict {look}"} in [attributes for tag, attributes in page.elements if tag == "div"]


def test_shapes_of_verdicts_differ(pages):
    shapes = {re.search(r'<svg class="shape".*?</svg>', html, re.DOTALL)[0] for html in pages.values()}

    assert len(shapes) == 5


def test_without_a_model_nothing_is_claimed(pages):
    text = Page(pages["nothing fitted"]).text

    for claim in ("Residuals", "could have shown", "Method", "no known cause"):
        assert claim not in text


WAVES = tuple(f"wave_6_{order}_{part}" for order in range(1, 61) for part in ("sin", "cos"))
CERTAIN = (
    "Amplitude ± standard uncertainty 0.0293 ± 0.0019 deg half the peak-to-peak value",
    "95 % interval of the amplitude 0.0256 to 0.0330 deg",  # 0.0293 -+ 1.96 * 0.0019
    "Improvement, held out 0.0223 mm (95 % interval 0.0171 to 0.0282 mm)",
    "reduction of the RMS held-out error",
    "p value < 0.0001",
    "Order 2 Phase 41.2 ± 3.7 deg",
    "Certain : no alternative explanation fits these data nearly as well",
    "the 95 % interval of the improvement lies above 0.",
    "This cause cannot be detected from these data. However, these data cannot show the following ",
    "the following similar causes at all:",
    "backlash: all configurations were approached from the same side",
    "wave_6_2_cos 0.0218 0.0013 deg",  # 3.8e-4 rad and 2.3e-5 rad
)
LIKELY = (
    "(2.07 ± 0.19) × 10⁻⁴",  # noqa: RUF001 - as it is printed
    "(1.70 to 2.44) × 10⁻⁴",  # noqa: RUF001
    "95 % interval −0.0002 to 0.0059 mm",  # noqa: RUF001
    "these data cannot distinguish this cause from joint harmonics, joint 2; "
    "the 95 % interval of the improvement includes 0",
    "No measurement that would distinguish them is proposed.",
)


@pytest.mark.parametrize(
    ("finding", "said"),
    [
        (make_finding(curve=None), CERTAIN),
        (make_gain_finding(curve=None), LIKELY),
        (make_finding(curve=None, parameters=WAVES), ("120, from wave_6_1_sin to wave_6_60_cos",)),
        (
            make_finding(curve=None, parameters=("no_such",)),
            ("This is the initial model: nothing was added.",),
        ),
        (
            make_finding(effect="gear_resonance", subject="joint 4", unit="mm/V", curve=None),
            ("Gear resonance, joint 4", "0.0293 ± 0.0019 mm/V"),
        ),
    ],
    ids=[
        "certain, with uncertainties and units", "likely, small and with a rival", "many parameters",
        "a parameter that the model does not hold", "an effect that the page has never heard of",
    ],
)  # fmt: skip
def test_a_finding_says(finding, said):
    text = page_of(plain(findings=(finding,))).text

    assert [words for words in said if words not in text] == []


def test_an_unknown_uncertainty_is_not_printed_as_zero():
    finding = make_finding(curve=None, amplitude_standard_uncertainty=float("nan"))

    text = page_of(plain(findings=(finding,))).text

    assert "standard uncertainty 0.0293 deg" in text
    assert "95 % interval of the amplitude" not in text


def test_a_gain_that_nothing_can_show_is_said():
    text = page_of(plain(findings=(make_finding(curve=None, gain=None),))).text

    assert "Improvement, held out not known there are no held-out readings to confirm it" in text
    assert "the 95 % interval of the improvement" not in text


def test_without_statistics_there_is_nothing_to_judge():
    assert "Before and after" not in page_of(plain(held_out="cross_validation")).text


@pytest.mark.parametrize(
    ("ending", "said"),
    [
        ("explained", ("On 300 held-out positions, used neither to choose the model",)),
        (
            "cross-validated",
            ("There is no validation file. Nested cross-validation on 50 positions",),
        ),
        (
            "lengths",
            ("On 180 held-out lengths", "Absolute length errors [mm]", "open dots shorter"),
        ),
        ("unexplained", ("heavier than normal: Student's t with 4.2 degrees of freedom",)),
        (
            "two findings",
            (
                "Yes. These data cannot distinguish this cause from: joint harmonics, joint 2. "
                "To distinguish them: Turn joint 2",
                "made held-out errors 0.002 mm worse and was withdrawn",
                "Joint angles [deg]",
                "1 0.00 −90.00 30.00 0.00 45.00 0.00",  # noqa: RUF001
            ),
        ),
    ],
)
def test_an_ending_says(pages, ending, said):
    text = Page(pages[ending]).text

    assert [words for words in said if words not in text] == []


def test_what_is_left_shows_what_it_depends_on(pages):
    page = Page(pages["partly explained"])

    assert "Time p < 0.0001" in page.text
    assert "Torque of joint 2 p = 0.004" in page.text
    pictures = [a["aria-label"] for tag, a in page.elements if tag == "svg" and "aria-label" in a]
    assert {"shift along x against time", "shift along x against torque of joint 2"} <= set(pictures)


def test_what_was_tried_and_what_cannot_be_seen_stand_apart():
    text = page_of(plain()).text

    tried, unseen = text.split("Causes that these data cannot show")
    assert "payload tool torques explain nothing more 0.55" in tried
    assert "thermal growth links the temperature changed by 0.4 K only" in unseen


def test_a_simulated_diagnosis_says_so_before_anything_else(tmp_path):
    conditions = ReportConditions(simulated=True)

    DiagnosisReport(plain(), conditions=conditions).write(tmp_path / "r.html")

    html = (tmp_path / "r.html").read_text()
    assert 0 < html.index("SIMULATED.") < html.index("<h1>")


def test_text_of_others_stays_text():
    finding = make_finding(
        subject=HOSTILE,
        effect=HOSTILE,
        unit=HOSTILE,
        sentence=HOSTILE,
        details=(Detail(HOSTILE, 1.0, HOSTILE, 0.1),),
        confusable_with=(Cause(HOSTILE, HOSTILE),),
        parameters=(HOSTILE,),
        curve=make_curve(variable=HOSTILE, quantity=HOSTILE, variable_unit=HOSTILE, quantity_unit=HOSTILE),
    )
    diagnosis = make_diagnosis(
        robot=HOSTILE,
        message=HOSTILE,
        findings=(finding, replace(finding, subject="other", curve=None)),
        errors=None,
        start_effects=(HOSTILE,),
        remaining=replace(NOTHING_LEFT, sentence=HOSTILE),
        next_measurements=(NextMeasurement(HOSTILE, (), (Cause(HOSTILE, HOSTILE),)),),
        ruled_out=(RuledOut(HOSTILE, HOSTILE, HOSTILE, 0.5), RuledOut(HOSTILE, "x", HOSTILE, None, False)),
        withdrawn=(HOSTILE,),
        model=make_model(identified_from={HOSTILE: HOSTILE}),
    )
    conditions = ReportConditions(
        robot_serial_number=HOSTILE, written_at=HOSTILE, notes=(HOSTILE,), load=HOSTILE
    )

    assert_hostile_text_stays_text(page_of(diagnosis, campaign=HOSTILE, conditions=conditions))


def test_the_origin_names_the_robot_and_the_campaign_once():
    model = make_model(identified_from={"robot": "irb", "campaign": "may", "readings": 30})

    html = DiagnosisReport(plain(model=model)).content()

    origin = re.findall(r"<dt>(.*?)</dt>", html[html.index('id="origin"') :])
    assert {"Robot", "Campaign", "Readings"} <= set(origin)
    assert len(origin) == len(set(origin))


def test_ten_thousand_readings_make_no_heavy_page():
    many = make_finding(curve=make_curve(n=10_000))
    diagnosis = make_diagnosis(findings=(many,), errors=make_errors(n=10_000))

    html = DiagnosisReport(diagnosis).content()

    # 400 dots with whiskers and 250 arrows four times, some 150 bytes each, and the words
    assert len(html) < 400_000
    assert "400 of 10,000 readings, evenly selected" in html


@pytest.mark.usefixtures("empty_pictures")
def test_readings_that_are_no_numbers_are_left_out_of_the_pictures():
    curve = make_curve()
    curve.residual[::2] = np.nan
    errors = make_errors()
    errors.after_mm[0] = np.nan
    nothing = make_curve(residual=np.full(100, np.nan))
    findings = (make_finding(curve=curve), make_finding(subject="joint 5", curve=nothing))

    text = page_of(make_diagnosis(findings=findings, errors=errors)).text

    assert ", 50 readings" in text
    assert "No plot: the readings do not show this cause" in text


def test_the_same_diagnosis_gives_the_same_page(pages):
    assert DiagnosisReport(two_findings()).content() == pages["two findings"]


def test_ids_of_pictures_do_not_meet(pages):
    html = pages["partly explained"]

    ids = re.findall(r'\bid="([^"]+)"', html)

    assert len(ids) == len(set(ids))
