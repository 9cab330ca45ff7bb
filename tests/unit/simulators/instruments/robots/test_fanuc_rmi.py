"""What the simulated controller with the Remote Motion Interface says, and what its program does."""

import asyncio
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import Kind, Packet
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove

DIALOGUE = json.loads((Path(__file__).parents[4] / "vectors" / "fanuc_rmi_dialogue.json").read_text())
ZEROS = {f"J{joint}": 0.0 for joint in range(1, 10)}
HOME = {"X": 475.0, "Y": 0.0, "Z": 375.0, "W": -180.0, "P": -90.0, "R": 0.0}
BENT = ZEROS | {"J3": -30.0, "J5": -30.0}


@pytest.fixture
def cell(make_cell):
    return make_cell("lrmate-tilted")


@pytest.fixture
def controller(cell):
    return Controller(cell)


@pytest.fixture
def program(controller):
    return RmiMove(controller)


def commanded(controller, name, **fields):
    answer = controller.answer(Packet(Kind.COMMAND, name, fields))
    assert answer.kind is Kind.COMMAND
    return answer.fields


async def ended(program, *instructions):
    """Have instructions carried out, and return what was told of them."""
    told = []
    program.tell = told.append
    for number, (name, fields) in enumerate(instructions, start=1):
        program.take(Packet(Kind.INSTRUCTION, name, {"SequenceID": number, **fields}))
    while len(told) < len(instructions):
        await asyncio.sleep(0)
    return [(packet.fields["SequenceID"], packet.fields["ErrorID"]) for packet in told]


def joints(angles, **changes):
    motion = {"JointAngle": angles, "SpeedType": "Percent", "Speed": 20, "TermType": "FINE"}
    return "FRC_JointMotionJRep", motion | changes


def straight(position, speed=100):
    where = {"Configuration": {"UToolNumber": 1, "UFrameNumber": 0}, "Position": position}
    return "FRC_LinearMotion", where | {"SpeedType": "mmSec", "Speed": speed, "TermType": "FINE"}


async def test_commands_of_public_clients_are_carried_out(controller):
    for row in DIALOGUE["requests"]:
        if row["kind"] == "Command" and row["name"] not in {"FRC_Abort"}:
            assert commanded(controller, row["name"], **row["fields"])["ErrorID"] == 0, row

    assert commanded(controller, "FRC_GetStatus")["Override"] == 50
    assert commanded(controller, "FRC_ReadError") == {"ErrorID": 0, "Count": 1, "ErrorData": "No Error"}
    assert commanded(controller, "FRC_Abort")["ErrorID"] == 0
    assert commanded(controller, "FRC_Abort")["ErrorID"] == protocol.NOT_RUNNING


async def test_the_home_position_is_stated_in_the_frames_that_it_is_in(controller):
    stated = commanded(controller, "FRC_ReadCartesianPosition")

    assert {key: stated["Position"][key] for key in HOME} == pytest.approx(HOME)
    assert stated["Configuration"]["UToolNumber"] == 1


async def test_joint_3_is_stated_from_the_horizontal(controller, program, cell):
    commanded(controller, "FRC_Initialize")

    assert await ended(program, joints(ZEROS | {"J1": 10.0, "J2": -20.5, "J3": 30.0})) == [(1, 0)]

    assert np.degrees(cell.robot.target_rad[:3]) == pytest.approx([10.0, -20.5, -9.5])
    shown = commanded(controller, "FRC_ReadJointAngles")["JointAngle"]
    assert [shown[axis] for axis in ("J1", "J2", "J3", "J9")] == [10.0, -20.5, 30.0, 0.0]


async def test_an_override_slows_every_motion(controller, program, cell):
    commanded(controller, "FRC_Initialize")
    commanded(controller, "FRC_SetOverRide", Value=50)

    await ended(program, joints(ZEROS | {"J1": 70.0}))

    assert cell.clock.now_s == pytest.approx(70.0 / (350.0 * 0.2 * 0.5))


async def test_instructions_wait_for_each_other_and_are_counted(controller, program):
    commanded(controller, "FRC_Initialize")

    told = await ended(program, joints(BENT), ("FRC_WaitTime", {"Time": 0.5}), joints(ZEROS))

    assert told == [(1, 0), (2, 0), (3, 0)]
    assert controller.status.next_sequence == 4
    program.take(Packet(Kind.INSTRUCTION, *_fields(joints(ZEROS), SequenceID=9)))
    assert controller.status.next_sequence == 4


def _fields(instruction, **more):
    name, fields = instruction
    return name, {**fields, **more}


async def test_straight_lines_keep_their_speed_and_end_where_they_were_sent(controller, program, cell):
    commanded(controller, "FRC_Initialize")
    await ended(program, joints(BENT))
    before = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    begun_s = cell.clock.now_s
    program.tell = lambda _: None
    wanted = before | {"X": before["X"] - 40.0, "Y": before["Y"] + 30.0}
    program.take(Packet(Kind.INSTRUCTION, *_fields(straight(wanted), SequenceID=2)))
    while cell.clock.now_s == begun_s:
        await asyncio.sleep(0)

    after = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    assert [after[axis] for axis in "XYZ"] == pytest.approx([wanted[axis] for axis in "XYZ"], abs=0.01)
    assert cell.clock.now_s - begun_s == pytest.approx(0.5, rel=0.01)  # 50 mm at 100 mm/s


async def test_increments_are_of_the_joints_or_of_the_position(controller, program):
    commanded(controller, "FRC_Initialize")
    step = ("FRC_JointRelativeJRep", joints(ZEROS | {"J1": 5.0})[1])
    relative = ("FRC_LinearRelative", straight(dict.fromkeys(HOME, 0.0) | {"Z": -20.0})[1])

    assert await ended(program, joints(BENT), step, step) == [(1, 0), (2, 0), (3, 0)]
    assert commanded(controller, "FRC_ReadJointAngles")["JointAngle"]["J1"] == 10.0
    before = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    commanded(controller, "FRC_Abort")
    commanded(controller, "FRC_Initialize")
    assert await ended(program, relative) == [(1, 0)]
    after = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    assert after == pytest.approx(before | {"Z": before["Z"] - 20.0}, abs=0.01)


async def test_frames_and_tools_are_what_was_taught(controller):
    shift = {"X": 100.0, "Y": 0.0, "Z": 0.0, "W": 0.0, "P": 0.0, "R": 90.0}
    commanded(controller, "FRC_WriteUFrameData", FrameNumber=2, Frame=shift)
    commanded(controller, "FRC_SetUFrameUTool", UFrameNumber=2, UToolNumber=3)

    position = commanded(controller, "FRC_ReadCartesianPosition")["Position"]

    assert (position["X"], position["Y"]) == pytest.approx((0.0, -375.0))
    assert commanded(controller, "FRC_ReadUFrameData", FrameNumber=2)["Frame"] == shift
    assert commanded(controller, "FRC_GetUFrameUTool") == {"ErrorID": 0, "UFrameNumber": 2, "UToolNumber": 3}


@pytest.mark.parametrize(
    "written",
    [
        {"Representation": "Joint", "JointAngle": BENT},
        {"Representation": "Cartesian", "Configuration": {"UToolNumber": 1}, "Position": HOME},
    ],
)
async def test_a_position_register_holds_what_was_written(controller, written):
    assert commanded(controller, "FRC_WritePositionRegister", RegisterNumber=5, **written) == {"ErrorID": 0}

    read = commanded(controller, "FRC_ReadPositionRegister", RegisterNumber=5)

    assert read == {"ErrorID": 0, "RegisterNumber": 5, **written}


async def test_the_speed_of_the_tool_is_that_of_the_motion(controller, program, cell, monkeypatch):
    def speed():
        return commanded(controller, "FRC_ReadTCPSpeed")["Speed"]

    commanded(controller, "FRC_Initialize")
    await ended(program, joints(BENT))
    assert speed() == 0.0
    here = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    asked_at = []
    monkeypatch.setattr(cell, "glide", lambda _: asked_at.append(speed()) or asyncio.sleep(0))

    program.take(Packet(Kind.INSTRUCTION, *_fields(straight(here | {"X": here["X"] - 40.0}), SequenceID=2)))
    while not asked_at:
        await asyncio.sleep(0)

    assert asked_at == [pytest.approx(100.0, rel=0.02)]


async def test_an_arc_leads_to_its_end(controller, program):
    commanded(controller, "FRC_Initialize")
    await ended(program, joints(BENT))
    here = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    wanted = here | {"X": here["X"] - 40.0}
    name, fields = "FRC_CircularMotion", straight(wanted)[1]
    via = {"ViaConfiguration": {}, "ViaPosition": here | {"X": here["X"] - 20.0, "Y": 20.0}}
    commanded(controller, "FRC_Abort")
    commanded(controller, "FRC_Initialize")

    assert await ended(program, (name, fields | via)) == [(1, 0)]

    after = commanded(controller, "FRC_ReadCartesianPosition")["Position"]
    assert after == pytest.approx(wanted, abs=0.01)


async def test_a_paused_motion_stands_until_it_is_continued(controller, program, cell, monkeypatch):
    glide, paused = cell.glide, []

    async def paused_half_way(duration_s):
        if not paused:
            paused.append(duration_s)
            await glide(duration_s / 2.0)
            commanded(controller, "FRC_Pause")
            await asyncio.sleep(0)
        await glide(duration_s)

    monkeypatch.setattr(cell, "glide", paused_half_way)
    commanded(controller, "FRC_Initialize")
    motion = asyncio.create_task(ended(program, joints(ZEROS | {"J1": 70.0})))
    while not paused or cell.robot_moves:
        await asyncio.sleep(0)

    assert commanded(controller, "FRC_GetStatus")["ProgramStatus"] == 2
    assert commanded(controller, "FRC_ReadJointAngles")["JointAngle"]["J1"] == 35.0
    assert not motion.done()

    commanded(controller, "FRC_Continue")

    assert await motion == [(1, 0)]
    assert commanded(controller, "FRC_GetStatus")["ProgramStatus"] == 0
    assert commanded(controller, "FRC_ReadJointAngles")["JointAngle"]["J1"] == 70.0


async def test_a_paused_program_can_be_aborted_and_begun_anew(controller, program):
    commanded(controller, "FRC_Initialize")
    commanded(controller, "FRC_Pause")
    program.take(Packet(Kind.INSTRUCTION, *_fields(joints(BENT), SequenceID=1)))
    await asyncio.sleep(0)

    commanded(controller, "FRC_Abort")
    commanded(controller, "FRC_Initialize")

    assert await ended(program, joints(BENT)) == [(1, 0)]


@pytest.mark.parametrize(
    ("name", "fields", "error"),
    [
        ("FRC_SetUFrameUTool", {"UFrameNumber": 11, "UToolNumber": 1}, protocol.BAD_FRAME),
        ("FRC_SetUFrameUTool", {"UFrameNumber": 0, "UToolNumber": 0}, protocol.BAD_TOOL),
        ("FRC_ReadUFrameData", {"FrameNumber": 0}, protocol.BAD_FRAME),
        ("FRC_ReadUToolData", {"ToolNumber": 12}, protocol.BAD_TOOL),
        ("FRC_SetOverRide", {"Value": 0}, protocol.BAD_OVERRIDE),
        ("FRC_SetOverRide", {}, protocol.BAD_VALUE),
        ("FRC_ReadPositionRegister", {"RegisterNumber": 101}, protocol.BAD_POSITION_REGISTER),
        ("FRC_ReadPositionRegister", {"RegisterNumber": 5}, protocol.BAD_POSITION_REGISTER),
        (
            "FRC_WritePositionRegister",
            {"RegisterNumber": 5, "Representation": "Matrix"},
            protocol.BAD_REPRESENTATION,
        ),
        (
            "FRC_WritePositionRegister",
            {"RegisterNumber": 5, "Representation": "Joint", "JointAngle": {"J1": 1.0}},
            protocol.BAD_VALUE,
        ),
        ("FRC_Pause", {}, protocol.NOT_RUNNING),
        *(("FRC_ReadError", {"Count": count}, protocol.BAD_VALUE) for count in (0, -1, 6)),
        ("FRC_MakeCoffee", {}, protocol.UNKNOWN_COMMAND),
    ],
)
def test_what_cannot_be_done_is_refused_by_number(controller, name, fields, error):
    assert commanded(controller, name, **fields)["ErrorID"] == error


@pytest.mark.parametrize(
    ("instruction", "error"),
    [
        (joints(ZEROS | {"J1": 175.0}), protocol.BAD_DESTINATION),
        (joints({"J1": 1.0}), protocol.BAD_POSITION_DATA),
        (joints(ZEROS, Speed=0), protocol.BAD_SPEED),
        (joints(ZEROS, Speed=101), protocol.BAD_SPEED),
        (joints(ZEROS, SpeedType="mmSec"), protocol.BAD_SPEED_TYPE),
        (joints(ZEROS, TermType="SOFT"), protocol.BAD_TERM_TYPE),
        (straight(HOME | {"X": 3000.0}), protocol.BAD_DESTINATION),
        (joints(ZEROS, TermType="CNT", TermValue=101), protocol.BAD_TERM_VALUE),
        (("FRC_SplineMotion", {}), protocol.UNKNOWN_INSTRUCTION),
        (("FRC_WaitTime", {"Time": -1.0}), protocol.BAD_VALUE),
    ],
)
async def test_a_motion_that_cannot_be_is_refused_and_moves_nothing(
    controller, program, cell, instruction, error
):
    commanded(controller, "FRC_Initialize")

    assert await ended(program, instruction) == [(1, error)]
    assert not cell.robot.target_rad.any()


async def test_after_an_error_all_is_held_until_the_program_is_begun_anew(controller, program):
    commanded(controller, "FRC_Initialize")
    told = await ended(program, joints(ZEROS | {"J1": 175.0}))
    program.tell = lambda packet: told.append(packet.fields["ErrorID"])
    program.take(Packet(Kind.INSTRUCTION, *_fields(joints(ZEROS), SequenceID=2)))
    assert told[-1] == protocol.IN_HOLD
    assert commanded(controller, "FRC_ReadError", Count=2)["ErrorData"] == "MOTN-017 Limit error"

    commanded(controller, "FRC_Abort")
    assert commanded(controller, "FRC_Initialize")["ErrorID"] == protocol.INVALID_STATE
    commanded(controller, "FRC_Reset")
    commanded(controller, "FRC_Initialize")

    assert await ended(program, joints(BENT)) == [(1, 0)]


async def test_after_a_reset_a_held_program_can_be_continued(controller, program):
    commanded(controller, "FRC_Initialize")
    await ended(program, joints(ZEROS | {"J1": 175.0}))

    commanded(controller, "FRC_Reset")
    commanded(controller, "FRC_Continue")
    told = []
    program.tell = lambda packet: told.append(packet.fields["ErrorID"])
    program.take(Packet(Kind.INSTRUCTION, *_fields(joints(BENT), SequenceID=2)))
    while not told:
        await asyncio.sleep(0)

    assert told == [0]


async def test_without_initialising_nothing_is_taken(controller, program, cell):
    assert await ended(program, joints(BENT)) == [(1, protocol.NOT_RUNNING)]
    assert not cell.robot.target_rad.any()


@pytest.mark.parametrize("change", [{"pendant_on": True}, {"servo_ready": False}, {"running": True}])
def test_a_controller_that_is_not_ready_is_not_initialised(controller, change):
    controller.status = replace(controller.status, **change)

    assert commanded(controller, "FRC_Initialize")["ErrorID"] == protocol.INVALID_STATE
