import io
import re

from rich.console import Console

from service.reports.summary import figures_table, truth_table
from service.reports.truth import TrueParameter
from tests.builders import make_identification, make_pair


def printed(table):
    console = Console(file=io.StringIO(), width=120)
    console.print(table)
    return console.file.getvalue()


def test_nominal_and_identified_errors_stand_one_above_the_other():
    text = printed(figures_table(make_identification(validation=make_pair(mean_mm=0.0278))))

    lines = [line.split() for line in text.splitlines()]
    assert any("nominal" in line and "0.100" in line for line in lines)
    assert any("identified" in line and "0.0278" in line for line in lines)
    assert "Position errors, mm" in text


def test_cross_validation_stands_in_where_nothing_was_held_out():
    text = printed(figures_table(make_identification()))

    assert "Cross-validation" in text
    assert "Validation" not in text


def test_parameters_are_compared_in_units_of_their_uncertainty():
    text = printed(truth_table([TrueParameter("a_3", 0.223, 0.2, 0.01, "mm")]))

    line = next(line for line in text.splitlines() if "a_3" in line)
    assert re.findall(r"[\w.+-]+", line) == ["a_3", "0.223", "0.200", "0.010", "mm", "+2.3"]


def test_names_in_square_brackets_are_no_markup():
    assert "[red]a_3" in printed(truth_table([TrueParameter("[red]a_3", 1.0, 1.0, 0.1, "mm")]))
