"""What names of columns say, in the words of several trades and languages."""

import pytest

from truepose.exchange.import_wizard.headings import (
    MEANS_NOTHING,
    QUANTITIES,
    ColumnMeaning,
    heading,
    motoman,
    series,
)

COLUMNS = [one for one in QUANTITIES.values() if one.column]


@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("q1_deg", ColumnMeaning("joint", 1, "deg")),
        ("q_1", ColumnMeaning("joint", 1)),
        ("J2[deg]", ColumnMeaning("joint", 2, "deg")),
        ("Joint 3 (rad)", ColumnMeaning("joint", 3, "rad")),
        ("joint_4_position", ColumnMeaning("joint", 4)),
        ("A5", ColumnMeaning("joint", 5)),
        ("rax_6", ColumnMeaning("joint", 6)),
        ("θ2 [°]", ColumnMeaning("joint", 2, "deg")),
        ("Achse 1 [Grad]", ColumnMeaning("joint", 1, "deg")),
        ("Gelenkwinkel 7 (Grad)", ColumnMeaning("joint", 7, "deg")),
        ("Axe 3 (degrés)", ColumnMeaning("joint", 3, "deg")),
        ("asse_2_rad", ColumnMeaning("joint", 2, "rad")),
        ("dir4", ColumnMeaning("direction", 4)),
        ("Anfahrrichtung 2", ColumnMeaning("direction", 2)),
        ("τ3 [Nm]", ColumnMeaning("torque", 3, "Nm")),
        ("Drehmoment 2 (Nm)", ColumnMeaning("torque", 2, "Nm")),
        ("X", ColumnMeaning("position", 1)),
        ("x_mm", ColumnMeaning("position", 1, "mm")),
        ("Y Ist [mm]", ColumnMeaning("position", 2, "mm")),
        ("PosZ (m)", ColumnMeaning("position", 3, "m")),
        ("smr1_x_mm", ColumnMeaning("position", 1, "mm")),
        ("meas.y [inch]", ColumnMeaning("position", 2, "in")),
        ("u_x_mm", ColumnMeaning("uncertainty", 0, "mm")),
        ("Unsicherheit [\u00b5m]", ColumnMeaning("uncertainty", 0, "um")),
        ("qw", ColumnMeaning("qw")),
        ("quat_x", ColumnMeaning("qx")),
        ("Reflektor", ColumnMeaning("nest")),
        ("SMR", ColumnMeaning("nest")),
        ("Pose", ColumnMeaning("config")),
        ("Nr.", ColumnMeaning("config")),
        ("Uhrzeit", ColumnMeaning("time")),
        ("time [min]", ColumnMeaning("time", 0, "min")),
        ("Temperatur [°C]", ColumnMeaning("temperature", 0, "C")),
        ("temp (K)", ColumnMeaning("temperature", 0, "K")),
        ("Länge (mm)", ColumnMeaning("length", 0, "mm")),
        ("longueur", ColumnMeaning("length")),
        ("repeat_of", ColumnMeaning("repeat_of")),
    ],
)
def test_a_name_says_what_its_column_is(name, meaning):
    assert heading(name).meaning == meaning


@pytest.mark.parametrize("name", ["", "remark", "dx [mm]", "deviation x", "force_x", "vel_y", "operator"])
def test_a_name_of_something_else_says_nothing_that_is_used(name):
    assert heading(name).meaning == MEANS_NOTHING


@pytest.mark.parametrize("quantity", COLUMNS, ids=lambda one: one.name)
def test_every_column_of_the_format_means_itself(quantity):
    meaning = heading(quantity.named(1)).meaning

    assert (meaning.column, meaning.unit) == (quantity.named(1), next(iter(quantity.units), ""))


def test_commanded_and_measured_are_told_apart():
    assert heading("x nominal").nominal
    assert heading("X Soll").nominal
    assert heading("x measured").measured
    assert not heading("x").nominal


def test_columns_named_alike_are_a_series():
    assert series("nivel_03") == ("nivel", 3)
    assert series("x1 y2") is None


def test_the_letters_of_a_yaskawa_are_its_joints_only_all_together():
    assert motoman(["no", "S", "L", "U", "R", "B", "T"]) == {1: 1, 2: 2, 3: 3, 4: 4, 5: 5, 6: 6}
    assert motoman(["S", "L", "U"]) == {}


def test_a_name_of_thousands_of_characters_says_what_its_beginning_says():
    assert heading("J1 (" + " " * 60_000 + "x") == heading("J1")
    assert heading("q" + "7" * 60_000).meaning == MEANS_NOTHING
    assert series("q" + "7" * 60_000) is not None
