"""The one sentence of a plan: error before and predicted after, limit, and what is predicted of it."""

import numpy as np
import pytest

from tests.helpers.web.pages import Page
from truepose.exchange.results.plans import plan_document
from truepose.messages.catalogue import LANGUAGES, catalogue, english
from truepose.planning.prediction.errors import CurvePoint, Discrepancy
from truepose.planning.prediction.outcome import plan_outcome
from truepose.planning.prediction.plan import Assumptions, PromisedPlan
from truepose.reports.checklist import ChecklistReport, checklist_of
from truepose.reports.plans import curve_table, promise_sentence

CURVE = tuple(
    CurvePoint(n, mean_mm, 2.5 * mean_mm, (0.7 * mean_mm, 1.4 * mean_mm), 1.1 * mean_mm)
    for n, mean_mm in ((2, 0.181), (11, 0.08), (20, 0.0412))
)
GRANTED = Assumptions(0.001, 0.01, Discrepancy(0.0))
PLAN = PromisedPlan(np.zeros((2, 6)), np.ones(2, dtype=int), None, CURVE, 11, 0, (), {}, GRANTED)
LARGEST = "largest 0.453 mm predicted, limit"


@pytest.mark.parametrize(
    ("limit_mm", "end"),
    [
        (None, "no limit set: set a limit to get a predicted pass or fail."),
        (0.5, f"{LARGEST} 0.5 mm: pass predicted."),
        (0.2, f"{LARGEST} 0.2 mm: fail predicted, pass predicted with 11 configurations."),
        (0.1, f"{LARGEST} 0.1 mm: fail predicted, even with 20 configurations."),
    ],
)
def test_it_says_what_is_known_before_what_is_predicted_and_whether_a_limit_is_kept(limit_mm, end):
    unknown, measured = (english(plan_outcome(PLAN, known, limit_mm)) for known in (None, 0.527))

    after = f"before (nominal), 0.181 mm predicted after 2 configurations; {end}"
    assert unknown == f"Mean error unknown {after}"
    assert measured == f"Mean error 0.527 mm {after}"


def test_document_and_checklist_begin_with_it_and_the_table_prints_the_same_figures():
    said = english(plan_outcome(PLAN, None, 0.2))
    sheet = ChecklistReport("IRB 120", "March", checklist_of(PLAN), 30.0, outcome=said).page()

    assert plan_document(PLAN, "IRB 120", 30.0, (), limit_mm=0.2).outcome == said
    assert f'</h1>\n<p class="outcome">{said}</p>' in sheet
    assert said in Page(str(sheet)).text
    assert curve_table(PLAN, catalogue("en")).rows[0][1:4:2] == ("0.181", "0.453")
    assert "0.181 mm over the work volume" in english(promise_sentence(PLAN))


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_it_in_the_units_of_its_reader(language):
    spoken = catalogue(f"{language}-x-inch").spoken(plan_outcome(PLAN, 0.527, 0.2))

    assert " in" in spoken
    assert "11" in spoken
    assert "mm" not in spoken
