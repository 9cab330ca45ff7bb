"""Dialogue with the simulated FANUC controller in exact bytes, and what it shows of its arm."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.clients import ProgramStoppedError
from truepose_simulators.instruments.robot.kinematics import (
    displayed_deg,
    flange_angles_deg,
    joints_rad,
    rotation_of,
    world,
)
from truepose_simulators.instruments.robot.mappdk import MappdkProgram
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.scenarios.scenario import ArmSetup

VECTORS = Path(__file__).parents[4] / "vectors"
ROWS = json.loads((VECTORS / "fanuc_orientations.json").read_text())["rows"]
DIALOGUE = json.loads((VECTORS / "mappdk_dialogue.json").read_text())
MOVE = DIALOGUE["requests"][2]["text"].strip()
ARM = ARMS["lrmate200ic"]


@pytest.fixture
def cell(make_cell):
    return make_cell("lrmate-tilted")


@pytest.fixture
def program(cell):
    return MappdkProgram(cell, "stock")


@pytest.mark.parametrize("row", ROWS, ids=lambda row: str(row["joints_deg"]))
def test_the_flange_turns_as_in_fanucs_own_simulator(row):
    joints = joints_rad(np.array(row["joints_deg"], dtype=float))

    rotation = nominal_flange(ARM, joints[np.newaxis])[0, :3, :3]

    assert rotation == pytest.approx(rotation_of(*row["wpr_deg"]), abs=1e-7)


@given(joints=st.lists(st.floats(-3.0, 3.0), min_size=6, max_size=6))
def test_what_is_shown_says_where_the_joints_are(joints):
    assert joints_rad(displayed_deg(np.array(joints))) == pytest.approx(joints, abs=1e-12)


@given(angles=st.tuples(st.floats(-180, 180), st.floats(-90, 90), st.floats(-180, 180)))
def test_flange_angles_say_which_way_the_flange_turns(angles):
    rotation = rotation_of(*angles)

    assert rotation_of(*flange_angles_deg(rotation)) == pytest.approx(rotation, abs=1e-6)


def test_the_world_stands_at_the_height_of_axis_2():
    assert world(ARM)[:3, 3].tolist() == [0.0, 0.0, 330.0]


async def test_a_session_of_the_public_client(program):
    replies = [await program.answer(request["text"].strip()) for request in DIALOGUE["requests"]]

    assert replies[0] == b"0:x= 475.000,y=   0.000,z= 375.000,w=-180.000,p= -90.000,r=   0.000"
    assert replies[1].startswith(b"0:j=   0.000,j=   0.000,j=")
    assert replies[1].endswith(b",j=none,j=none,j=none")
    assert replies[2] == b"0:success"
    assert replies[3] == b"1:position-is-not-reachable"  # joint 2 at 360 deg
    assert replies[5:] == [
        b"0:0.300000",
        b"0:success",
        b"0:success",
        b"0:1",
        b"0:success",
        b"0:0",
        b"0:success",
    ]


async def test_joint_3_is_shown_from_the_horizontal(program, cell):
    assert await program.answer(MOVE) == b"0:success"

    assert np.degrees(cell.robot.target_rad) == pytest.approx([10.0, -20.5, -9.5, 0.0, -45.0, 0.0], abs=1e-9)
    assert (await program.answer("curjpos")).startswith(b"0:j=  10.000,j= -20.500,j=  30.000,j=")


async def test_a_reply_to_a_move_comes_when_the_arm_is_at_rest(program, cell):
    await program.answer("movej:0050:0100:000:0:6:+000070.000000" + ":+000000.000000" * 5)

    assert not cell.robot.moving(cell.clock.now_s)
    assert cell.clock.now_s == pytest.approx(0.4)  # 70 deg at half of 350 deg/s


async def test_a_pose_is_reached_on_a_straight_line_at_its_speed(program, cell):
    await program.answer("movej:0100:0100:000:0:6" + "".join(f":{a:+014.6f}" for a in (0, 0, -30, 0, -30, 0)))
    before = [float(word.split("=")[1]) for word in (await program.answer("curpos")).decode()[2:].split(",")]
    started_s = cell.clock.now_s
    target = [before[0] - 40.0, before[1] + 30.0, *before[2:]]

    reply = await program.answer("movep:0100:0100:000:1:6" + "".join(f":{v:+014.6f}" for v in target))
    after = [float(word.split("=")[1]) for word in (await program.answer("curpos")).decode()[2:].split(",")]

    assert reply == b"0:success"
    assert after[:3] == pytest.approx(target[:3], abs=0.002)
    assert cell.clock.now_s - started_s == pytest.approx(0.5, rel=0.01)  # 50 mm at 100 mm/s


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        ("", b"1:wrong-command"),
        ("hello", b"1:wrong-command"),
        ("identity", b"1:wrong-command"),
        ("watch:0800", b"1:wrong-command"),
        ("beat", b"1:wrong-command"),
        ("movet:00010:1:+000001.000000", b"1:wrong-command"),
        ("movej", b"1:error-in-joint-values"),
        ("movej:0050:0100:000:0:5" + ":+000000.000000" * 5, b"1:error-in-joint-values"),
        ("movej:abcd:0100:000:0:6" + ":+000000.000000" * 6, b"1:R[81]-was-not-set"),
        ("movep:0050:0100:000:0:6:+009000.000000" + ":+000000.000000" * 5, b"1:position-is-not-reachable"),
        ("movep:0050:0100:000:0:1:+000500.000000", b"1:position-is-not-reachable"),
        ("setrdo:1:maybe", b"1:wrong-rdo-value"),
        ("setdout:00001", b"1:wrong-dout-value"),
        ("exit", b"0:success"),
    ],
)
async def test_what_the_stock_program_does_not_do_it_says(program, cell, line, reply):
    assert await program.answer(line) == reply
    assert not cell.robot.target_rad.any()


async def test_our_own_program_tells_who_it_is_and_more_decimals(cell):
    program = MappdkProgram(cell, "truepose")

    assert await program.answer("identity") == b"0:truepose 1,LR Mate 200iC,SIM-1,V7.70P;"
    assert await program.answer("beat") == b""
    assert await program.answer("watch:0800") == b"0:success"
    assert await program.answer("watch:soon") == b"1:wrong-watch-value"
    assert await program.answer("movet:00025:6:+000010.123456" + ":+000000.000000" * 5) == b"0:success"
    assert cell.clock.now_s == pytest.approx(2.5)
    assert (await program.answer("curjpos")).startswith(b"0:j=  10.12346,j=")


@pytest.mark.parametrize("speed", ["0000", "0101"])
async def test_a_speed_that_is_none_is_a_fault(program, speed):
    with pytest.raises(ProgramStoppedError, match="speed"):
        await program.answer(f"movej:{speed}:0100:000:0:6" + ":+000000.000000" * 6)


@pytest.mark.parametrize(("refusal", "drops"), [("hang", False), ("drop", True)])
async def test_scripted_faults_befall_the_move_they_name(make_cell, refusal, drops):
    cell = make_cell("lrmate-tilted", arm=ArmSetup(refusal=refusal))
    program = MappdkProgram(cell)
    cell.faults.add(RobotRefuses(move=1))
    cell.faults.add(RobotHangs(move=2))

    with pytest.raises(ProgramStoppedError) as caught:
        await program.answer(MOVE)
    stood = cell.robot.target_rad.copy()
    with pytest.raises(ProgramStoppedError):
        await program.answer(MOVE)

    assert caught.value.drops is drops
    assert not stood.any()
    assert np.degrees(cell.robot.target_rad[0]) == pytest.approx(10.0)  # a hung robot has moved all the same


def test_a_protocol_that_nobody_speaks_is_no_scenario():
    with pytest.raises(Exception, match=r'"open_abb" or .*"mappdk"'):
        ArmSetup(protocol="morse")
