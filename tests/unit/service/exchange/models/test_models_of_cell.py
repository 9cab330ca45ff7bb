"""A model that is handed to a cell is one for it, or is refused with what differs."""

import json
from dataclasses import replace

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from truepose.domain.cell import Cell
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.identification import NestCentre
from truepose.domain.robot import Nest
from truepose.exchange.models.acceptance import fitting_model
from truepose.exchange.models.file import model_text

MODEL = model_of(IRB_120, *plain_parameters(IRB_120))
NESTS = tuple(Nest(nest.centre_mm) for nest in MODEL.nests)


def handed(model=MODEL, **of_cell):
    cell = Cell("bench", "abb-irb-120", **{"robot": IRB_120, "nests": NESTS, **of_cell})
    return fitting_model(json.loads(model_text(model)), cell).model


def test_a_model_of_this_robot_and_tool_is_one_of_the_cell():
    assert handed().robot.name == "ABB IRB 120"
    assert handed(nests=()).nests == MODEL.nests
    assert handed(nests=(Nest(None),)).nests == MODEL.nests


def test_a_robot_with_another_table_is_another_one():
    joints = (replace(IRB_120.joints[0], d_mm=300.0), *IRB_120.joints[1:])

    with pytest.raises(UnsuitableModelError, match="with a different joint table"):
        handed(robot=replace(IRB_120, joints=joints))
    with pytest.raises(UnsuitableModelError, match="this cell has ABB IRB 1200"):
        handed(robot=replace(IRB_120, name="ABB IRB 1200"))


def test_another_tool_is_said_with_how_far_apart():
    x, y, z = MODEL.nests[0].centre_mm
    nearly = replace(MODEL, nests=(NestCentre(1, (x + 0.05, y, z)), *MODEL.nests[1:]))
    moved = replace(MODEL, nests=(NestCentre(1, (x + 3.0, y, z)), *MODEL.nests[1:]))
    fewer = replace(MODEL, nests=(*MODEL.nests, NestCentre(9, (x, y, z))))

    assert handed(nearly).nests == nearly.nests
    with pytest.raises(UnsuitableModelError, match="up to 3 mm away"):
        handed(moved)
    with pytest.raises(UnsuitableModelError, match="a tool of"):
        handed(fewer)
