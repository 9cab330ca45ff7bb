"""The first page: pass or not, one figure, one picture, one sentence, who and when."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.diagnosed_cells import consistent, nothing_fitted
from tests.helpers.domain.builders import make_statistics
from tests.helpers.web.pages import Page
from truepose.domain.identification import NominalAndIdentified
from truepose.domain.validation import (
    Decision,
    FigureUncertainty,
    UncertaintyPair,
    Validation,
    ValidationUncertainty,
)
from truepose.messages.catalogue import IN_ENGLISH
from truepose.reports.cover_page import error_bars, front_page
from truepose.reports.diagnosis.report import diagnosis_front
from truepose.reports.traceability import Period, ReportConditions
from truepose.reports.validation import validation_front

PAIR = NominalAndIdentified(
    make_statistics(n=300, mean_mm=1.0, max_mm=2.0), make_statistics(n=300, mean_mm=0.03, max_mm=0.09)
)
KNOWN = UncertaintyPair(
    FigureUncertainty(0.01, 0.01, 0.01, 0.02), FigureUncertainty(0.002, 0.002, 0.002, 0.018)
)
FOUND = Validation(
    "position", PAIR, None, 0.2, True, 0.03,
    decision=Decision("guard band", 0.2, 0.09, 0.03, "conforms"),
    uncertainty=ValidationUncertainty(position=KNOWN),
)  # fmt: skip


def front(**changes):
    return validation_front(replace(FOUND, **changes), "IRB 120", IN_ENGLISH)


@pytest.mark.parametrize(
    ("verdict", "word", "look"),
    [
        ("conforms", "PASSED", "consistent"),
        ("does not conform", "FAILED", "failed"),
        ("cannot be decided", "CANNOT BE DECIDED", "not_answered"),
    ],
)
def test_the_decision_with_its_uncertainty_is_the_first_word(verdict, word, look):
    made = front(decision=replace(FOUND.decision, verdict=verdict))

    assert (made.word, made.look) == (word, look)


def test_the_figure_is_the_largest_error_with_its_expanded_uncertainty():
    figure = front().figure

    assert figure.value == "0.0900 mm"
    assert figure.remark == "U = 0.036 mm (k = 2), of 300 readings"


def test_without_a_limit_nothing_passes():
    made = front(limit_mm=None, decision=None)

    assert "PASSED" not in made.word
    assert made.word == "AS PREDICTED"
    assert "No limit was set" in made.rule


def test_the_rule_is_said_as_it_was_applied():
    simple = front(decision=replace(FOUND.decision, rule="simple"))

    assert "guard band to ISO 14253-1" in front().rule
    assert "simple acceptance" in simple.rule


def test_a_diagnosis_without_an_answer_has_neither_figure_nor_picture():
    made = diagnosis_front(nothing_fitted(), IN_ENGLISH)

    assert (made.figure, made.picture, made.look) == (None, None, "not_answered")
    assert diagnosis_front(consistent(), IN_ENGLISH).look == "consistent"


@pytest.mark.parametrize(
    ("nominal", "named"), [(None, "before"), (make_statistics(mean_mm=0.5, max_mm=0.9), "nominal")]
)
def test_the_first_bar_of_a_diagnosis_is_named_after_the_model_that_it_is_of(nominal, named):
    page = Page(str(diagnosis_front(replace(consistent(), nominal=nominal), IN_ENGLISH).picture))

    assert page.text.startswith(named)


def test_bars_stand_on_one_scale_with_the_limit():
    page = Page(str(error_bars(*_both(), IN_ENGLISH, 4.0)))
    widths = [float(one["width"]) for tag, one in page.elements if tag == "rect"]

    largest_before, mean_before, largest_after, _ = widths
    assert largest_before == pytest.approx(2.0 * mean_before, abs=0.1)
    assert largest_before / largest_after == pytest.approx(2.0 / 0.09, rel=0.02)
    assert "limit 4 mm" in page.text


def test_errors_of_nothing_are_bars_of_nothing():
    nothing = make_statistics(mean_mm=0.0, max_mm=0.0)

    page = Page(str(error_bars(nothing, nothing, IN_ENGLISH)))

    assert {one["width"] for tag, one in page.elements if tag == "rect"} == {"0.0"}


def test_who_when_and_which_report():
    conditions = ReportConditions(
        person="R. Calder", robot_serial_number="120-5", number="Validation 12, revision 2",
        sessions=(Period("a", "2026-11-01", "2026-11-02"), Period("b", "2026-11-03", "2026-11-04")),
        closing="Closed although <b>it</b> had expired.", overridden=True,
    )  # fmt: skip

    made = str(front_page(front(), conditions, IN_ENGLISH))
    page = Page(made)

    for said in ("R. Calder", "serial number 120-5", "Validation 12, revision 2", "2026-11-01 to 2026-11-04"):
        assert said in page.text
    assert '<p class="warning" role="note">Closed although &lt;b&gt;it' in made


def test_what_nobody_said_is_not_stated():
    assert "not stated" in Page(str(front_page(front(), ReportConditions(), IN_ENGLISH))).text


def _both():
    return PAIR.nominal, PAIR.identified
