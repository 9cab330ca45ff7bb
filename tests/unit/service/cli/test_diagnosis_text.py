"""A diagnosis on a terminal: the first line is the answer, every number has its unit and its doubt."""

import math

import pytest

from tests.helpers.diagnosis.answers import (
    make_described,
    make_diagnosis,
    make_finding,
    make_rest,
    make_unexplained,
    make_wave,
)
from truepose.cli.diagnosis_text import diagnosis_lines, errors_on_terminal
from truepose.domain.diagnosis import Gain, Remaining


def test_the_message_follows_the_outcome_however_long():
    message = "The model misses something. " * 20

    lines = list(diagnosis_lines(make_diagnosis(message=message)))

    assert lines[0].startswith("Mean error ")
    assert lines[1] == message


def test_a_finding_states_its_sentence_amplitude_doubt_and_gain():
    lines = list(diagnosis_lines(make_diagnosis()))

    assert lines[2] == "1. Joint 3 stops 0.021 deg further on when it comes from below: backlash."
    assert lines[3] == "   Amplitude 0.0210 ± 0.0030 deg; likely, p < 0.0001."
    assert lines[4] == (
        "   Improvement: held-out RMS error reduced by 0.0420 mm (95 % interval 0.0360 to 0.0470 mm)."
    )
    assert (
        lines[5] == "   Alternative explanations that these data cannot rule out: joint harmonics, joint 3."
    )


def test_small_findings_are_told_below_and_not_numbered():
    lines = list(diagnosis_lines(make_diagnosis(small=(make_wave(),))))

    at = lines.index(
        "Small findings, included in the model; each reduces the held-out RMS error by less than 2 %:"
    )
    assert lines[at + 1] == "   Joint 6 has a periodic error of 2 periods per turn, amplitude 0.029 deg."
    assert not [line for line in lines if line.startswith("2. ")]
    assert not [line for line in diagnosis_lines(make_diagnosis()) if "Small" in line]


def test_what_is_left_and_what_to_measure_next_close_it():
    lines = list(diagnosis_lines(make_diagnosis()))

    assert lines[6] == "The residuals are consistent with the stated noise."
    assert lines[-3:] == [
        "Measure next: Measure these from both sides.",
        "   joints 0.00 40.00 -30.00 deg",
        "   joints 5.00 45.00 -25.00 deg",
    ]


def test_structure_without_a_name_says_what_it_depends_on():
    lines = list(diagnosis_lines(make_unexplained(withdrawn=("A wave of joint 2 did not help.",))))

    assert "Withdrawn: A wave of joint 2 did not help." in lines
    assert "Depends on: angle of joint 4 (p = 0.0001)." in lines


def test_what_is_described_without_a_name_is_a_sentence_and_a_line_each():
    left = make_rest(make_described(), make_described(where="nest 2", over="constant"))

    lines = list(diagnosis_lines(make_unexplained(remaining=left)))

    at = next(k for k, line in enumerate(lines) if line.startswith("Modelled empirically"))
    assert lines[at + 1 : at + 3] == [
        "   joint 2 as a function of angle of joint 1: RMS error 0.120 mm without this term; tool "
        "displacement 0.300 mm on average, 0.900 mm at most.",
        "   nest 2: RMS error 0.120 mm without this term; tool displacement 0.300 mm on average, "
        "0.900 mm at most.",
    ]


def test_where_nothing_is_described_nothing_is_said_of_it():
    assert not [line for line in diagnosis_lines(make_unexplained()) if "Modelled empirically" in line]


def test_what_the_first_line_says_of_what_is_left_is_not_said_again():
    left = make_unexplained().remaining.sentence

    lines = list(diagnosis_lines(make_unexplained(message=f"No known cause explains it. {left}")))

    assert sum(left in line for line in lines) == 1


@pytest.mark.parametrize("gain", [None, Gain(math.nan, math.nan, (math.nan, math.nan))])
def test_a_gain_that_nothing_shows_is_no_number(gain):
    lines = list(diagnosis_lines(make_diagnosis(findings=(make_finding(gain=gain),))))

    assert not any("nan" in line for line in lines)


def test_errors_stand_before_and_after():
    table = errors_on_terminal(make_diagnosis())

    assert list(table.columns[0].cells) == ["initial model", "after"]
    assert list(table.columns[3].cells) == ["0.0610", "0.0190"]
    assert "cross-validation" in table.caption


def test_where_nothing_could_be_fitted_the_reason_is_said_once():
    why = "There are too few readings."
    unanswered = make_unexplained(
        message=why, remaining=Remaining(False, (), why), before=None, after=None, noise=None, model=None
    )

    assert list(diagnosis_lines(unanswered))[1:] == [why]


def test_where_nothing_could_be_fitted_there_is_no_table():
    assert errors_on_terminal(make_unexplained(before=None, after=None, model=None)) is None
