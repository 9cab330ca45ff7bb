"""The sentence that every result begins with, and that whatever shows one begins with it."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.domain.builders import make_identification, make_statistics
from truepose.cli.diagnosis_text import diagnosis_lines
from truepose.domain.identification import NominalAndIdentified
from truepose.domain.validation import Decision, Validation
from truepose.exchange.results.diagnosis import diagnosis_document
from truepose.exchange.results.identification import identification_document
from truepose.exchange.results.validation import accuracy_document, validation_document
from truepose.messages.catalogue import IN_ENGLISH, LANGUAGES, catalogue, english
from truepose.reports.diagnosis.report import diagnosis_front
from truepose.reports.validation import validation_front
from truepose.validation.outcome import Outcome, outcome_of

NOMINAL, MODEL = make_statistics(mean_mm=0.499), make_statistics(mean_mm=0.0331, max_mm=0.0812)
PAIR = NominalAndIdentified(NOMINAL, MODEL)
DECISION = Decision("guard band", 0.1, 0.0812, 0.01, "conforms")
VALIDATION = Validation("position", PAIR, None, 0.1, True, decision=DECISION)
IDENTIFICATION = make_identification(validation=PAIR)
DIAGNOSIS = make_diagnosis(nominal=NOMINAL, after=MODEL)
BOTH = "Mean error 0.499 mm before (nominal), 0.0331 mm after; "


@pytest.mark.parametrize(
    ("found", "end"),
    [
        (VALIDATION, "largest 0.0812 mm, limit 0.1 mm: pass."),
        (replace(VALIDATION, decision=replace(DECISION, verdict="does not conform")), "limit 0.1 mm: fail."),
        (
            replace(VALIDATION, decision=replace(DECISION, verdict="cannot be decided")),
            "limit 0.1 mm: cannot be decided.",
        ),
        (
            replace(VALIDATION, decision=None, limit_mm=None),
            "no limit set: set a limit to get a pass or fail.",
        ),
        (IDENTIFICATION, "no limit set: validate to get a pass or fail."),
        (DIAGNOSIS, "no limit set: validate to get a pass or fail."),
    ],
)
def test_it_says_before_after_limit_and_pass_or_what_is_missing(found, end):
    said = english(outcome_of(found))

    assert said.startswith(BOTH)
    assert said.endswith(end)


def test_a_diagnosis_compares_with_nominal_and_not_with_the_model_that_it_starts_from():
    started = replace(DIAGNOSIS, before=MODEL)

    assert english(outcome_of(started)).startswith(BOTH)


@pytest.mark.parametrize(
    ("found", "said"),
    [
        (Outcome(None, MODEL), "Mean error not recorded before (nominal), 0.0331 mm after; "),
        (Outcome(NOMINAL, MODEL, "length"), "Mean length error 0.499 mm before (nominal), 0.0331 mm after; "),
        (Outcome(None, None), "No model was identified, so there is no error after "),
    ],
)
def test_what_is_not_known_is_said_to_be_so(found, said):
    assert english(found.sentence).startswith(said)


def test_everything_that_shows_a_result_begins_with_it():
    shown = {
        validation_front(VALIDATION, "elbow", IN_ENGLISH).outcome,
        validation_document(VALIDATION)["outcome"],
        accuracy_document(VALIDATION, None).outcome,
    }
    judged = {
        diagnosis_front(DIAGNOSIS, IN_ENGLISH).outcome,
        next(diagnosis_lines(DIAGNOSIS)),
        diagnosis_document(DIAGNOSIS)["outcome"],
        identification_document(IDENTIFICATION, "elbow")["outcome"],
    }

    assert shown == {english(outcome_of(VALIDATION))}
    assert judged == {english(outcome_of(DIAGNOSIS))}


@pytest.mark.parametrize("language", LANGUAGES)
def test_it_is_said_in_every_language_with_the_readers_units(language):
    said = catalogue(f"{language}-x-inch").spoken(outcome_of(VALIDATION))

    assert "0.0" in said.replace(",", ".")
    assert " in" in said
    assert "mm" not in said
