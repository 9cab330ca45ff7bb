"""The lines that the demo prints of a diagnosis."""

from truepose.demo.report import diagnosis_lines


def test_a_diagnosis_without_findings_is_its_message():
    assert list(diagnosis_lines({"message": "Nothing was found.", "findings": []})) == [
        "Diagnosis: Nothing was found."
    ]


def test_every_finding_says_how_sure_it_is():
    findings = [
        {"sentence": "Joint 6 is off by a wave.", "confidence": "certain"},
        {"sentence": "The base moves.", "confidence": "likely"},
    ]

    lines = list(diagnosis_lines({"message": "The model lacks two causes.", "findings": findings}))

    assert lines[1:] == ["  1. Joint 6 is off by a wave. (certain)", "  2. The base moves. (likely)"]
