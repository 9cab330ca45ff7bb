"""What is said of a cause over the months, in English and by the catalogue of every other language."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding
from truepose.diagnosis.history import DatedDiagnosis, compare
from truepose.domain.diagnosis import Detail
from truepose.messages.catalogue import IN_ENGLISH, LANGUAGES, catalogue
from truepose.reports.history_sentences import change_words

SPRING, AUTUMN = "2026-03-03", "2026-10-02"


def backlash(amplitude, u=0.003, **changes):
    return make_finding(amplitude=amplitude, amplitude_standard_uncertainty=u, **changes)


def said(before, after, days=(SPRING, AUTUMN), words=IN_ENGLISH):
    """What is said of the first cause of two diagnoses."""
    first, *_ = compare([
        DatedDiagnosis(number, day, make_diagnosis(findings=(finding,), ruled_out=()))
        for number, (day, finding) in enumerate(zip(days, (before, after), strict=True), start=1)
    ])
    return change_words(first, first.changes[0], words)


def test_a_backlash_that_grew_is_said_with_its_uncertainty_and_days():
    assert said(backlash(0.021, 0.0024), backlash(0.033, 0.0032)) == (
        "Backlash, joint 3 grew by 0.0120 ± 0.0040 deg between 2026-03-03 and 2026-10-02: "
        "significant (p 0.0027)."
    )


def test_a_difference_that_chance_explains_is_said_to_be_one():
    sentence = said(backlash(0.021), backlash(0.018))

    assert "fell by 0.0030 ± 0.0042 deg" in sentence
    assert "not significant (p" in sentence


def test_a_coupling_names_the_joint_that_it_comes_from():
    def coupling(size):
        detail = Detail("source joint", 5.0, "1", 0.0), Detail("coupling", size, "rad/rad", 0.001)
        return make_finding(effect="joint_coupling", subject="joint 6", unit="rad/rad", details=detail)

    assert said(coupling(0.021), coupling(0.071)).startswith(
        "Joint coupling, joint 6, source joint 5 grew by"
    )


def test_without_an_uncertainty_it_is_said_that_nothing_was_tested():
    assert "not tested" in said(backlash(0.021, 0.0), backlash(0.05, 0.0))


def test_a_gain_that_changed_its_sign_has_turned_round():
    gain = make_finding(
        effect="joint_gain", subject="joint 2", unit="1", amplitude=2e-4, amplitude_standard_uncertainty=2e-5
    )

    sentence = said(gain, replace(gain, amplitude=-1e-4))

    assert sentence.startswith("Joint gain, joint 2 changed sign, by")


def test_diagnoses_of_one_day_are_told_apart_by_the_minute():
    day = ("2026-03-03T08:15:30.000+00:00", "2026-03-03T12:00:01.000+00:00")

    assert "between 2026-03-03 08:15 and 2026-03-03 12:00" in said(backlash(0.02), backlash(0.02), day)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_it_with_its_numbers(language):
    words = catalogue(language)
    sentence = said(backlash(0.021, 0.0024), backlash(0.033, 0.0032), words=words)

    assert f"0{words.units.decimal}0120" in sentence
    assert SPRING in sentence
