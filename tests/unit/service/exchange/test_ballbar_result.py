"""Result files of the QC20-W: what is known of them is read, the rest is named, other files are refused."""

import pytest

from truepose.exchange.ballbar_result import Feature, ballbar_result_from_bytes, read_ballbar_result
from truepose.exchange.errors import MissingFileError, UnreadableFileError

# Written by hand after the elements that a public reader looks for; the raw element's name is invented.
RESULT = """<?xml version="1.0" encoding="utf-8"?>
<BALLBAR_RESULT>
  <TEST_SPEC NAME="XY 360deg 150mm"><PLANE TEST_PLANE="XY"/></TEST_SPEC>
  <OPERATOR> M. Dupont </OPERATOR>
  <DATE_STARTED>2026-01-05 10:15:00</DATE_STARTED>
  <MACHINE_TESTED NAME="DMU 50"/>
  <BALLBAR><SERIAL_NUMBER>12A345</SERIAL_NUMBER><LAST_CALIBRATED>2025-11-30</LAST_CALIBRATED></BALLBAR>
  <FEATURE NAME="Circularity" DT="R">4.6</FEATURE>
  <FEATURE NAME="Backlash X &gt;" DT="R">-0.9</FEATURE>
  <FEATURE NAME="Remark" DT="S">warm</FEATURE>
  <SAMPLES>1 2 3</SAMPLES><SAMPLES>4</SAMPLES>
</BALLBAR_RESULT>
"""
NAME = "XY 360deg 150mm 20260105-101500_172001002.b5r"


def read(text: str, name: str = NAME, encoding: str = "utf-8"):
    return ballbar_result_from_bytes(text.encode(encoding), name)


def test_head_and_features_are_read():
    result = read(RESULT)

    assert (result.test, result.plane, result.machine) == ("XY 360deg 150mm", "XY", "DMU 50")
    assert (result.operator, result.started) == ("M. Dupont", "2026-01-05 10:15:00")
    assert (result.ballbar_serial, result.last_calibrated) == ("12A345", "2025-11-30")
    assert result.features == (
        Feature("Circularity", "R", "4.6"),
        Feature("Backlash X >", "R", "-0.9"),
        Feature("Remark", "S", "warm"),
    )
    assert [feature.value for feature in result.features] == [4.6, -0.9, None]


def test_what_is_not_understood_is_named_and_counted():
    assert read(RESULT).not_understood == {"BALLBAR": 1, "BALLBAR_RESULT": 1, "SAMPLES": 2}


def test_the_part_number_may_stand_in_the_files_name_and_goes_after_the_one_inside():
    inside = RESULT.replace("<OPERATOR>", "<PART_NUMBER>P-9</PART_NUMBER><OPERATOR>")

    assert read(RESULT).part_number == "172001002"
    assert read(inside).part_number == "P-9"
    assert read(RESULT, name="result.b5r").part_number == ""


def test_of_what_comes_twice_the_first_counts():
    twice = RESULT.replace("</BALLBAR>", "</BALLBAR><SERIAL_NUMBER>OTHER</SERIAL_NUMBER>")

    assert read(twice).ballbar_serial == "12A345"


def test_other_encodings_of_windows_programs_are_read():
    text = RESULT.replace('encoding="utf-8"', 'encoding="utf-16"').replace("Dupont", "Müller")

    assert read(text, encoding="utf-16").operator == "M. Müller"


@pytest.mark.parametrize("number", ["nan", "inf", "4,6", "4_6", "1e999", ""])
def test_a_text_that_is_no_number_has_no_value(number):
    assert read(RESULT.replace(">4.6<", f">{number}<")).features[0].value is None


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not a ballbar test result"),
        ("config,x_mm\n1,2\n", "line 1: is not a ballbar test result"),
        (RESULT[:300], "not a ballbar test result"),
        ("<html><body/></html>", "not a ballbar test result"),
        (RESULT.replace('encoding="utf-8"', 'encoding="banana"'), "its encoding is not known"),
        ('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "document type"),
    ],
)
def test_another_file_is_refused_in_one_sentence(text, said):
    with pytest.raises(UnreadableFileError, match=said) as refused:
        read(text)

    assert str(refused.value).startswith(NAME)
    assert str(refused.value).endswith(".")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(MissingFileError, match=r"none\.b5r"):
        read_ballbar_result(tmp_path / "none.b5r")
