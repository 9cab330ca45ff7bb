"""What the simulated controller behind a variable proxy says of itself, and lets be written."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from truepose_drivers.kuka_variable_proxy.protocol import Mode, Request, decode_aggregate, decode_axes
from truepose_simulators.cell.robot import SpeedLimits, nominal_flange
from truepose_simulators.instruments.robot.kinematics import rotation_of
from truepose_simulators.instruments.robot.kuka import Variables

VECTORS = json.loads((Path(__file__).parents[4] / "vectors" / "kuka_variable_proxy.json").read_text())
JOINTS = np.radians([30.0, -70.0, 40.0, 10.0, 20.0, 30.0])


@pytest.fixture
def cell(make_cell):
    return make_cell("kr6-clean")


@pytest.fixture
def variables(cell):
    return Variables(cell)


def read(variables, name):
    answer = variables.answer(Request(7, name))
    assert (answer.number, answer.mode, answer.done) == (7, Mode.READ, True)
    return answer.value


def write(variables, name, value):
    return variables.answer(Request(7, name, value)).done


async def test_axes_and_position_are_those_of_the_arm(variables, cell):
    await cell.move_robot([JOINTS], SpeedLimits(), np.zeros(3))

    assert np.radians(decode_axes(read(variables, "$AXIS_ACT"))[:6]) == pytest.approx(JOINTS, abs=1e-7)
    stated = {
        name: float(value) for name, value in decode_aggregate(read(variables, "$POS_ACT"), "E6POS").items()
    }
    flange = nominal_flange(cell.plant.arm, JOINTS[np.newaxis])[0]
    assert [stated[axis] for axis in "XYZ"] == pytest.approx(flange[:3, 3].tolist(), abs=1e-4)
    assert rotation_of(stated["C"], stated["B"], stated["A"]) == pytest.approx(flange[:3, :3], abs=1e-7)
    assert list(stated) == list(decode_aggregate(VECTORS["position"], "E6POS"))


def test_no_answer_is_longer_than_a_public_client_reads(variables, cell):
    variables.program.target_deg = (-123.456789,) * 12
    longest = max(
        len(read(variables, name)) for name in ("$AXIS_ACT", "$POS_ACT", "TP_STATE", "$MODEL_NAME[]")
    )

    assert longest + 10 < 256


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("PING", "PONG"),
        ("$PRO_STATE", "#P_ACTIVE"),
        ("$pro_state1", "#P_ACTIVE"),
        ("$MODE_OP", "#EX"),
        ("$OV_PRO", "100"),
        ("$KR_SERIALNO", "SIM-1"),
        ("$MODEL_NAME[]", '"#KR 6 R900 sixx"'),
        ("TP_NUMBER", "0"),
        ("$NO_SUCH_THING", ""),
        ("", ""),
    ],
)
def test_variables_say_what_they_are(variables, name, value):
    assert read(variables, name) == value


@pytest.mark.parametrize(
    ("name", "value", "done"),
    [
        ("$OV_PRO", "30", True),
        ("$OV_PRO", "much", False),
        ("$AXIS_ACT", "{A1 0}", False),
        ("$NO_SUCH_THING", "1", False),
        ("TP_TARGET", "{A1 1.0,A2 2.0,A3 3.0,A4 4.0,A5 5.0,A6 6.0}", True),
        ("TP_TARGET", "{A1 1.0}", False),
        ("TP_PERCENT", "-1", False),
        ("TP_STATE", "{BEGUN 1}", False),
    ],
)
def test_variables_let_be_written_what_they_can_be(variables, name, value, done):
    before = read(variables, name)

    assert write(variables, name, value) is done
    if not done:
        assert read(variables, name) == before


def test_a_controller_without_our_program_has_none_of_its_variables(cell):
    variables = Variables(cell, "stock")

    assert read(variables, "TP_STATE") == ""
    assert not write(variables, "TP_NUMBER", "1")
    assert math.isfinite(decode_axes(read(variables, "$AXIS_ACT"))[0])
