"""A validation is told in French throughout: its report with a test of ISO 9283, and its tables."""

import re

import pytest

from tests.helpers.domain.lost_visit import MODEL, readings_of_model
from tests.helpers.printed import printed
from tests.helpers.web.pages import Page
from tests.helpers.words.english import english_in
from truepose.messages.catalogue import catalogue
from truepose.reports.pose_test import pose_test_summary
from truepose.reports.traceability import ReportConditions
from truepose.reports.validation import ValidationReport, validation_summary
from truepose.validation.iso9283.pose_test import pose_test
from truepose.validation.validate import validate

FRENCH = catalogue("fr")


@pytest.fixture(scope="module")
def points():
    return readings_of_model()


def text_of(path, points, language="fr", limit_mm=None, test=None):
    found = validate(MODEL, points, limit_mm=limit_mm)
    conditions = ReportConditions(load="2.6 kg")
    report = ValidationReport(found, MODEL, points, pose_test=test, conditions=conditions, language=language)
    report.write(path)
    return Page(re.sub("<style.*?</style>", "", path.read_text("utf-8"), flags=re.DOTALL)).text


def test_a_report_with_a_test_of_iso_9283_is_french_throughout(tmp_path, points):
    text = text_of(tmp_path / "report.html", points, limit_mm=0.2, test=pose_test(MODEL, points))

    assert "Avec une bande de garde de" in text
    assert "exactitude de pose" in text
    assert "avant/haut" in text
    assert english_in(text) == []


@pytest.mark.usefixtures("empty_pictures")
def test_the_same_report_in_english_is_seen(tmp_path, points):
    text = text_of(tmp_path / "report.html", points, "en", limit_mm=0.2, test=pose_test(MODEL, points))

    assert {"the", "of", "with"} <= set(english_in(text))


@pytest.mark.parametrize(
    ("limit_mm", "rule", "told"),
    [
        (None, "guard band", "conforme \u00e0 l\u2019exactitude pr\u00e9vue"),
        (0.2, "guard band", "(ISO 14253-1, 95\u00a0%), il est conforme"),
        (0.01, "guard band", "il n\u2019est pas conforme"),
        (0.051, "guard band", "on ne peut d\u00e9cider"),
        (0.2, "simple", "Par acceptation simple, il est conforme"),
        (0.01, "simple", "Par acceptation simple, il n\u2019est pas conforme"),
    ],
)
def test_every_verdict_is_told_in_french(points, limit_mm, rule, told):
    text = printed(validation_summary(validate(MODEL, points, limit_mm=limit_mm, rule=rule), FRENCH))

    assert told in text
    assert english_in(text) == []


def test_a_table_of_iso_9283_speaks_french_too(points):
    text = printed(pose_test_summary(pose_test(MODEL, points), FRENCH))

    assert "Non donn\u00e9\u00a0:" in text
    assert "Command\u00e9 par" in text
    assert english_in(text) == []
