"""What columns are taken for, how surely, and why: files that differ from the examples."""

import numpy as np
import pytest

from tests.unit.service.exchange.import_wizard.tables import plain, readings, table
from truepose.exchange.import_wizard.column_detection import guess_columns
from truepose.exchange.import_wizard.sheet import read_sheet
from truepose.messages.catalogue import LANGUAGES, catalogue

ANGLES = [f"q{k}_deg" for k in range(1, 7)]
JOINTS = [f"q{k}" for k in range(1, 7)]


def guesses_of(data, name="mine.csv"):
    return guess_columns(read_sheet(name, data))


def columns_of(data):
    return [guess.meaning.column for guess in guesses_of(data)]


def test_plain_words_with_units_are_certain():
    guesses = guesses_of(plain())

    assert {guess.certainty for guess in guesses} == {"certain"}
    assert [guess.meaning.column for guess in guesses][1:9] == [*ANGLES, "nest", "x_mm"]


def test_units_that_nobody_says_are_guessed_by_size_and_called_likely():
    joints, _, places = readings()
    names = [*(f"J{k}" for k in range(1, 7)), "X", "Y", "Z"]

    guesses = guesses_of(table(names, np.column_stack([np.radians(joints), places / 1000.0])))

    assert [guess.meaning.unit for guess in guesses] == ["rad"] * 6 + ["m"] * 3
    assert {guess.certainty for guess in guesses} == {"likely"}


@pytest.mark.parametrize("name", ["kulma", "joint_"])
def test_columns_that_are_numbered_alike_in_any_language_are_joints_also_counted_from_nought(name):
    joints, _, places = readings()
    names = [*(f"{name}{k}" for k in range(6)), "x", "y", "z"]

    assert columns_of(table(names, np.column_stack([joints, places])))[:6] == ANGLES


def test_without_names_the_usual_order_is_no_more_than_a_guess():
    joints, _, places = readings()

    guesses = guesses_of(table([], np.column_stack([np.arange(30), joints, places])).lstrip())

    assert [guess.meaning.column for guess in guesses] == ["config", *ANGLES, "x_mm", "y_mm", "z_mm"]
    assert {guess.certainty for guess in guesses} == {"guess"}


def test_of_commanded_and_reported_joints_the_commanded_ones_are_used():
    joints, _, places = readings()
    names = [*(f"q{k} actual" for k in range(1, 7)), *(f"q{k} cmd" for k in range(1, 7)), "x", "y", "z"]

    columns = columns_of(table(names, np.column_stack([joints, joints, places])))

    assert columns[:6] == [""] * 6
    assert columns[6:12] == ANGLES


def test_of_nominal_and_measured_points_the_measured_ones_are_used_and_nominal_ones_alone_never():
    joints, _, places = readings()
    nominal = [*JOINTS, *(f"{a} nominal" for a in "xyz")]
    both = [*nominal, *(f"{a} measured" for a in "xyz")]

    columns = columns_of(table(both, np.column_stack([joints, places, places])))

    assert columns[6:] == ["", "", "", "x_mm", "y_mm", "z_mm"]
    assert columns_of(table(nominal, np.column_stack([joints, places])))[6:] == ["", "", ""]


@pytest.mark.parametrize("names", ["mA_x mA_y mA_z mB_x mB_y mB_z", "x1 y1 z1 x2 y2 z2"])
def test_several_points_of_a_row_are_told_apart(names):
    joints, _, places = readings()

    guesses = guesses_of(table([*JOINTS, *names.split()], np.column_stack([joints, places, places])))

    assert [guess.meaning.point for guess in guesses[6:]] == [1, 1, 1, 2, 2, 2]


def test_a_column_of_remarks_is_nothing_and_a_joint_that_holds_words_no_joint():
    assert columns_of(b"q1,x,remark\n1,2.5,cold\n2,3.5,warm\n3,4,x\n")[2] == ""
    assert columns_of(b"q1,q2,x,y,z\nup,1.5,1,2,3\ndown,1.5,1,2,3\n")[0] == ""


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_reason_can_be_said(language):
    for guess in (*guesses_of(plain()), *guesses_of(b"a,b,c\n1,2.5,3\n")):
        assert not catalogue(language).spoken(guess.reason).startswith("bring.")
