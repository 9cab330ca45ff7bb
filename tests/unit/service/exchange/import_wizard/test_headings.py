"""What names of columns say, in the words of several trades and languages."""

import pytest

from truepose.exchange.import_wizard.headings import (
    MEANS_NOTHING,
    QUANTITIES,
    Meaning,
    heading,
    motoman,
    series,
)

COLUMNS = [one for one in QUANTITIES.values() if one.column]


@pytest.mark.parametrize(
    ("name", "meaning"),
    [
        ("q1_deg", Meaning("joint", 1, "deg")),
        ("q_1", Meaning("joint", 1)),
        ("J2[deg]", Meaning("joint", 2, "deg")),
        ("Joint 3 (rad)", Meaning("joint", 3, "rad")),
        ("joint_4_position", Meaning("joint", 4)),
        ("A5", Meaning("joint", 5)),
        ("rax_6", Meaning("joint", 6)),
        ("θ2 [°]", Meaning("joint", 2, "deg")),
        ("Achse 1 [Grad]", Meaning("joint", 1, "deg")),
        ("Gelenkwinkel 7 (Grad)", Meaning("joint", 7, "deg")),
        ("Axe 3 (degrés)", Meaning("joint", 3, "deg")),
        ("asse_2_rad", Meaning("joint", 2, "rad")),
        ("dir4", Meaning("direction", 4)),
        ("Anfahrrichtung 2", Meaning("direction", 2)),
        ("τ3 [Nm]", Meaning("torque", 3, "Nm")),
        ("Drehmoment 2 (Nm)", Meaning("torque", 2, "Nm")),
        ("X", Meaning("position", 1)),
        ("x_mm", Meaning("position", 1, "mm")),
        ("Y Ist [mm]", Meaning("position", 2, "mm")),
        ("PosZ (m)", Meaning("position", 3, "m")),
        ("smr1_x_mm", Meaning("position", 1, "mm")),
        ("meas.y [inch]", Meaning("position", 2, "in")),
        ("u_x_mm", Meaning("uncertainty", 0, "mm")),
        ("Unsicherheit [\u00b5m]", Meaning("uncertainty", 0, "um")),
        ("qw", Meaning("qw")),
        ("quat_x", Meaning("qx")),
        ("Reflektor", Meaning("nest")),
        ("SMR", Meaning("nest")),
        ("Pose", Meaning("config")),
        ("Nr.", Meaning("config")),
        ("Uhrzeit", Meaning("time")),
        ("time [min]", Meaning("time", 0, "min")),
        ("Temperatur [°C]", Meaning("temperature", 0, "C")),
        ("temp (K)", Meaning("temperature", 0, "K")),
        ("Länge (mm)", Meaning("length", 0, "mm")),
        ("longueur", Meaning("length")),
        ("repeat_of", Meaning("repeat_of")),
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
