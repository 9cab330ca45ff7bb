"""Dialogue with the robot controller in exact bytes.

Requests are those that the public open_abb client puts on the wire; replies follow the format strings of
its RAPID program (NumToStr: whole numbers without decimals).
"""

import numpy as np
import pytest

from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.clients import ProgramStoppedError
from truepose_simulators.instruments.robot.open_abb import MotionProgram
from truepose_simulators.scenarios.scenario import ArmSetup

MOVE = b"02 +0010.00 -0020.55 +0030.00 +0000.00 +0045.00 +0000.00 #"
TOOL = b"06 +00000.0 +00000.0 +00125.0 +1.00000 +0.00000 +0.00000 +0.00000 #"


@pytest.fixture
def cell(make_cell):
    return make_cell()


@pytest.fixture
def program(cell):
    return MotionProgram(cell)


async def talk(program, *requests):
    return [await program.answer(request) for request in requests]


async def test_a_session_of_the_public_client(program):
    replies = await talk(
        program,
        b"06 +00000.0 +00000.0 +00000.0 +1.00000 +0.00000 +0.00000 +0.00000 #",
        b"07 +00000.0 +00000.0 +00000.0 +1.00000 +0.00000 +0.00000 +0.00000 #",
        b"08 +00100.0 +0050.00 +00050.0 +0050.00 #",
        b"09 0 +01.0000 +01.0000 +00.1000 #",
        b"98 #",
        b"03 #",
        MOVE,
        b"04 #",
        b"05 #",
        b"99 #",
    )

    assert replies == [
        b"6 1 ",
        b"7 1 ",
        b"8 1 ",
        b"9 1 ",
        b"98 1 SIM-1*5.61.0100*IRB 120-3/0.6",
        b"3 1 374 0 630 0.707 0 0.707 0",
        b"2 1 ",
        b"4 1 10 -20.55 30 0 45 0",
        b"5 1 9E+09 9E+09 9E+09 9E+09 9E+09 9E+09",
        None,
    ]


async def test_five_decimals_reach_the_arm_and_two_come_back(program, cell):
    replies = await talk(
        program, b"2 +0010.12345 +0000.00000 +0000.00000 +0000.00000 +0000.00000 +0000.00000 #"
    )

    assert replies == [b"2 1 "]
    assert np.degrees(cell.robot.target_rad[0]) == pytest.approx(10.12345, abs=1e-12)
    assert await program.answer(b"4 #") == b"4 1 10.12 0 0 0 0 0"


async def test_a_reply_to_a_move_comes_when_the_arm_is_at_rest(program, cell):
    await talk(program, b"8 1000 90 #", b"2 90 0 0 0 0 0 #")

    assert not cell.robot.moving(cell.clock.now_s)
    assert cell.clock.now_s == pytest.approx(1.0, rel=1e-9)  # 90 deg at 90 deg/s


@pytest.mark.parametrize(
    ("request_", "reply"),
    [
        (b"2 1 2 3 4 5 #", b"2 0 "),  # one joint too few
        (b"2 1 2 3 4 5 6 7 #", b"2 0 "),
        (b"4 1 #", b"4 0 "),
        (b"8 100 #", b"8 0 "),
        (b"8 100 50 0 #", b"8 0 "),
        (b"77 #", b"77 0 "),
        (b"2 1 2 3 4 5 6#", b"2 0 "),  # the value that runs into the mark is not counted
        (b"002 1 2 3 4 5 #", b"2 0 "),
        (b"0 #", b"0 1 "),
    ],
)
async def test_a_message_that_does_not_fit_its_code_is_refused(program, cell, request_, reply):
    assert await program.answer(request_) == reply
    assert not cell.robot.target_rad.any()


@pytest.mark.parametrize(
    "corrupt", [b"4", b"hello #", b"", b"4 nan #", b"\xff\xff", b"4 " + b"1 " * 60 + b"#"]
)
async def test_a_corrupt_message_is_refused_under_the_code_of_the_one_before(program, corrupt):
    await program.answer(b"8 100 50 #")

    assert await program.answer(corrupt) == b"8 0 "


@pytest.mark.parametrize(("refusal", "drops"), [("hang", False), ("drop", True)])
async def test_a_target_out_of_range_stops_the_program(make_cell, refusal, drops):
    cell = make_cell(arm=ArmSetup(refusal=refusal))

    with pytest.raises(ProgramStoppedError, match="joint 1 cannot go to") as caught:
        await MotionProgram(cell).answer(b"2 166 0 0 0 0 0 #")

    assert caught.value.drops is drops
    assert not cell.robot.target_rad.any()


async def test_scripted_failures_befall_the_move_they_name(program, cell):
    cell.faults.add(RobotRefuses(move=2))
    cell.faults.add(RobotHangs(move=3))

    await program.answer(b"2 1 0 0 0 0 0 #")
    with pytest.raises(ProgramStoppedError):
        await program.answer(b"2 2 0 0 0 0 0 #")
    refused_at = np.degrees(cell.robot.target_rad[0])
    with pytest.raises(ProgramStoppedError):
        await program.answer(b"2 3 0 0 0 0 0 #")

    assert refused_at == pytest.approx(1.0)
    assert np.degrees(cell.robot.target_rad[0]) == pytest.approx(3.0)  # a hung robot has moved all the same


async def test_a_pose_is_told_in_the_tool_and_work_object_that_were_set(program):
    replies = await talk(
        program,
        TOOL,
        b"07 +00100.0 +00000.0 +00000.0 +1.00000 +0.00000 +0.00000 +0.00000 #",
        b"03 #",
    )

    assert replies[-1] == b"3 1 399 0 630 0.707 0 0.707 0"  # 374 + 125 - 100 in front


async def test_a_straight_move_arrives_at_its_pose_in_the_same_branch(program, cell):
    await talk(program, b"2 0 0 0 0 60 0 #")
    pose = (await program.answer(b"3 #")).decode().split()[2:]
    x, y, z, *quaternion = map(float, pose)
    request = f"1 {x - 50:.1f} {y + 40:.1f} {z - 30:.1f} {' '.join(map(str, quaternion))} #"

    replies = await talk(program, request.encode(), b"3 #")

    assert replies[0] == b"1 1 "
    arrived = [float(word) for word in replies[1].split()[2:5]]
    assert arrived == pytest.approx([x - 50, y + 40, z - 30], abs=0.06)  # sent with one decimal
    assert abs(np.degrees(cell.robot.target_rad[4])) < 120


async def test_a_pose_out_of_reach_stops_the_program(program):
    with pytest.raises(ProgramStoppedError, match="reaches the pose"):
        await program.answer(b"1 2000 0 500 1 0 0 0 #")


@pytest.mark.parametrize("x", ["1e9", "1e99"])
async def test_a_pose_beyond_the_moon_stops_the_program_at_once(program, x):
    with pytest.raises(ProgramStoppedError, match="out of the arm's reach"):
        await program.answer(f"1 {x} 0 500 1 0 0 0 #".encode())


async def test_a_quaternion_of_no_length_stops_the_program(program):
    with pytest.raises(ProgramStoppedError):
        await program.answer(b"6 0 0 0 0 0 0 0 #")


async def test_buffered_poses_are_visited_one_by_one_at_their_own_speeds(program, cell):
    await talk(program, b"2 0 0 0 0 60 0 #", b"31 #")
    pose = (await program.answer(b"3 #")).decode().split()[2:]
    x, rest = float(pose[0]), " ".join(pose[1:])
    started_s = cell.clock.now_s

    replies = await talk(
        program,
        b"8 100 1000 #",
        f"30 {x - 20:.2f} {rest} #".encode(),
        b"8 10 1000 #",
        f"30 {x - 40:.2f} {rest} #".encode(),
        b"32 #",
        b"33 #",
        b"31 #",
        b"32 #",
    )

    assert replies[4:] == [b"32 1 2", b"33 1 ", b"31 1 ", b"32 1 0"]
    # 20 mm at 100 mm/s and 20 mm at 10 mm/s.
    assert cell.clock.now_s - started_s == pytest.approx(2.2, rel=0.01)


async def test_the_buffer_holds_512_poses_and_ignores_more(program):
    for _ in range(514):
        assert await program.answer(b"30 300 0 600 1 0 0 0 #") == b"30 1 "

    assert await program.answer(b"32 #") == b"32 1 512"


async def test_an_arc_needs_its_point_on_the_circle_first(program):
    with pytest.raises(ProgramStoppedError, match="point of the circle"):
        await program.answer(b"36 300 0 600 0.707 0 0.707 0 #")


async def test_an_arc_ends_at_its_end(program):
    await talk(program, b"2 0 0 0 0 60 0 #")
    pose = (await program.answer(b"3 #")).decode().split()[2:]
    x, y, rest = float(pose[0]), float(pose[1]), " ".join(pose[2:])

    replies = await talk(
        program,
        f"35 {x - 20:.2f} {y + 20:.2f} {rest} #".encode(),
        f"36 {x - 40:.2f} {y:.2f} {rest} #".encode(),
        b"3 #",
    )

    assert replies[:2] == [b"35 1 ", b"36 1 "]
    assert [float(word) for word in replies[2].split()[2:4]] == pytest.approx([x - 40, y], abs=0.011)


async def test_external_axes_report_what_was_last_commanded(program):
    replies = await talk(program, b"34 -550 0 0 1234567.89 0 0 #", b"5 #")

    assert replies == [b"34 1 ", b"5 1 -550 0 0 1234567. 0 0"]  # each cut to eight characters


async def test_a_restarted_program_has_forgotten_tool_and_speed(program):
    await talk(program, TOOL)

    program.restart()

    assert await program.answer(b"3 #") == b"3 1 374 0 630 0.707 0 0.707 0"
