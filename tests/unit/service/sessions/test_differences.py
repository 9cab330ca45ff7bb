"""What a cell is today that it was not then: each part by its own sentence; nothing where none changed."""

from dataclasses import replace

import pytest

from tests.helpers.domain.builders import make_robot
from truepose.domain.cell import Artefact, Cell
from truepose.messages.catalogue import english
from truepose.sessions.cell import differences

THEN = Cell(name="left", robot_key="elbow", robot=make_robot(), robot_serial_number="7")


def test_the_same_cell_differs_in_nothing_whatever_it_is_called():
    assert list(differences(THEN, replace(THEN, name="left arm", people=("Ada",)))) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"robot_serial_number": "8"}, "a different serial number"),
        ({"tool": Artefact("plate", "P-2")}, "The tool"),
        ({"tracker_position_mm": (0.0, 0.0, 1.0)}, "tracker"),
        ({"robot": make_robot(repeatability_mm=0.5)}, "kinematic table or joint limits"),
    ],
)
def test_each_part_that_changed_is_named_alone(change, said):
    (sentence,) = differences(THEN, replace(THEN, **change))

    assert said in english(sentence)
