"""The lines that the demo prints of a diagnosis."""

from truepose.demo.report import diagnosis_lines

OUTCOME = "Mean error 0.499 mm before (nominal), 0.033 mm after; no limit stated: validate."


def test_a_diagnosis_without_findings_is_its_outcome_and_its_message():
    document = {"outcome": OUTCOME, "message": "Nothing was found.", "findings": []}

    assert list(diagnosis_lines(document)) == [OUTCOME, "Diagnosis: Nothing was found."]


def test_every_finding_says_how_sure_it_is():
    findings = [
        {"sentence": "Joint 6 is off by a wave.", "confidence": "certain"},
        {"sentence": "The base moves.", "confidence": "likely"},
    ]

    document = {"outcome": OUTCOME, "message": "The model lacks two causes.", "findings": findings}
    lines = list(diagnosis_lines(document))

    assert lines[2:] == ["  1. Joint 6 is off by a wave. (certain)", "  2. The base moves. (likely)"]
