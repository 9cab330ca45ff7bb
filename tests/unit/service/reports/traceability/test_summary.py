import re
from dataclasses import replace

import pytest

from tests.helpers.domain.builders import make_identification, make_pair
from tests.helpers.printed import printed
from truepose.domain.identification import NotIdentifiable, Outlier
from truepose.domain.validation import Decision, Validation
from truepose.reports.identification.summary import (
    TrueParameter,
    identification_summary,
    truth_table,
)
from truepose.reports.tables import on_terminal
from truepose.reports.validation import validation_summary


def test_nominal_and_identified_errors_stand_one_above_the_other():
    text = printed(identification_summary(make_identification(validation=make_pair(mean_mm=0.0278))))

    lines = [line.split() for line in text.splitlines()]
    assert any("nominal" in line and "0.100" in line for line in lines)
    assert any("identified" in line and "0.0278" in line for line in lines)
    assert "Position errors, mm" in text


def test_the_summary_names_what_is_open_and_what_got_no_weight():
    identification = make_identification(
        not_identifiable=(NotIdentifiable(("d_2", "d_3"), "axes 2 and 3 are parallel"),),
        outliers=(Outlier(4, 12, 1, 3.2, "off by [bold]3.2 mm"),),
    )

    text = printed(identification_summary(identification))

    assert text.startswith("Mean error 0.100 mm before (nominal), 0.100 mm after; ")
    assert "The identification converged." in text
    assert "Cross-validation" in text
    assert re.search(r"alpha_2\W+0.0573\W+0.0057\W+deg", text)
    assert "Not determined by these data: d_2, d_3. Reason: axes 2 and 3 are parallel." in text
    assert "Configuration 12, nest 1 has zero weight: off by [bold]3.2 mm." in text


def test_the_summary_of_what_was_not_fitted_is_its_message():
    identification = make_identification(
        model=None, parameters=(), calibration=None, cross_validation=None, message="Too few data."
    )

    assert printed(identification_summary(identification)).splitlines()[1:] == ["Too few data."]


def test_a_model_worse_than_the_nominal_one_is_called_so():
    pair = make_pair()
    worse = replace(pair, identified=replace(pair.identified, mean_mm=pair.nominal.mean_mm + 1.0))

    text = printed(validation_summary(Validation("position", worse, None, None, False, 0.02)))

    assert "mean error of the identified model is not below that of the nominal model" in text


@pytest.mark.parametrize(
    ("decision", "passed", "sentence"),
    [
        (Decision("simple", 0.2, 0.1, 0.0, "conforms"), True, "Simple acceptance: the robot conforms. "),
        (
            None,
            True,
            "is below that of the nominal model and consistent with the predicted accuracy.",
        ),
        (
            None,
            False,
            "the readings are from another robot, frame or unit, or the robot has changed.",
        ),
    ],
)
def test_a_validation_ends_with_its_verdict(decision, passed, sentence):
    limit_mm = None if decision is None else decision.limit_mm
    validation = Validation(
        "position", make_pair(), make_pair(mean_mm=0.031), limit_mm, passed, 0.02, decision=decision
    )

    text = printed(validation_summary(validation))

    assert sentence in " ".join(text.split())[-150:]
    assert re.search(r"Distance between points, all pairs\W+nominal", text)
    assert "0.0310" in text


def test_cross_validation_stands_in_where_nothing_was_held_out():
    text = printed(identification_summary(make_identification()))

    assert "Cross-validation" in text
    assert "Validation" not in text


def test_parameters_are_compared_in_units_of_their_uncertainty():
    text = printed(on_terminal(truth_table([TrueParameter("a_3", 0.223, 0.2, 0.01, "mm")])))

    line = next(line for line in text.splitlines() if "a_3" in line)
    assert re.findall(r"[\w.+-]+", line) == ["a_3", "0.223", "0.200", "0.010", "mm", "+2.3"]


def test_names_in_square_brackets_are_no_markup():
    assert "[red]a_3" in printed(on_terminal(truth_table([TrueParameter("[red]a_3", 1.0, 1.0, 0.1, "mm")])))
