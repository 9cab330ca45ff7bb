"""What scripted faults do to a cell, its cables and its arm."""

import asyncio
import json

import numpy as np
import pytest

from tests.helpers.ballbar.length_sources import FakeBar, electronics
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import (
    KINDS,
    BallbarZeroJumps,
    EmergencyStop,
    LinkCut,
    LinkHalfOpen,
    ProtectiveStop,
    TemperatureStep,
    ToolSlips,
    TripodKicked,
    WrongCup,
)
from truepose_simulators.faults.scripted import Faults
from truepose_simulators.instruments.cable import FaultyCable
from truepose_simulators.instruments.cell_endpoints import _OPERATIONS, carry_out
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.physics.rigid import apply

SLOW = SpeedLimits(tool_mm_s=20.0, orientation_rad_s=0.05)
FAR_RAD = np.radians([40.0, 20.0, 10.0, 0.0, 30.0, 0.0])


def tool_nests_mm(cell):
    return cell.true_positions(cell.conditions_now())[0]


def test_a_tool_that_slips_and_a_tripod_that_is_kicked_move_what_they_carry_and_nothing_else(make_cell):
    cell = make_cell(noise=False)
    nests, frame, fixed = tool_nests_mm(cell), cell.tracker.frame, cell.fixed_nests_mm()

    cell.add_fault(ToolSlips(by_mm=(0.3, 0.0, 0.0)))
    cell.add_fault(TripodKicked(by_mm=(0.0, 0.4, 0.0)))

    turn = cell.rest(cell.conditions_now()).bodies.last_frame[0, :3, :3]
    assert tool_nests_mm(cell) - nests == pytest.approx(np.tile(apply(turn, np.array([0.3, 0, 0])), (3, 1)))
    assert (cell.tracker.frame - frame)[:3, 3] == pytest.approx([0.0, 0.4, 0.0])
    assert np.array_equal(cell.fixed_nests_mm(), fixed)


def test_a_door_that_is_opened_is_felt_until_it_is_closed(make_cell):
    cell = make_cell(noise=False)
    before_c = cell.air.sensed_c(100.0, None)

    cell.add_fault(TemperatureStep(by_k=-4.0, from_s=50.0, until_s=150.0))

    assert cell.air.sensed_c(100.0, None) == pytest.approx(before_c - 4.0)
    assert cell.air.sensed_c(150.0, None) == pytest.approx(before_c, abs=0.05)  # the cell's own wave


def test_a_gauge_whose_zero_jumped_shows_that_much_more():
    faults, bar = Faults(), FakeBar()
    faults.add(BallbarZeroJumps(by_mm=0.05))

    assert electronics(bar, faults).show().deviation_mm == pytest.approx(bar.deviation_mm + 0.05)


def test_a_person_who_errs_takes_another_cup_once(make_cell):
    cell = make_cell()
    cell.add_fault(WrongCup(cup=2))

    assert [cell.cup_taken(1), cell.cup_taken(1)] == [2, 1]


@pytest.mark.parametrize("kind", [EmergencyStop, ProtectiveStop])
async def test_a_stop_halts_the_arm_on_its_way_and_holds_it(make_cell, kind):
    cell = make_cell()
    cell.add_fault(kind(move=1, after_s=2.0, for_s=10.0))
    cell.faults.next_move()

    with pytest.raises(ArmStoppedError):
        await cell.move_robot([FAR_RAD], SLOW, np.zeros(3))
    halted_s, place = cell.now_s, cell.robot.target_rad
    with pytest.raises(ArmStoppedError):
        await cell.move_robot([FAR_RAD], SLOW, np.zeros(3))
    await cell.clock.sleep(10.0)
    still = np.array_equal(cell.robot.target_rad, place)
    await cell.move_robot([FAR_RAD], SLOW, np.zeros(3))

    assert halted_s == pytest.approx(2.0)
    assert still
    assert np.array_equal(cell.robot.target_rad, FAR_RAD)


async def test_a_stop_that_is_pressed_during_a_motion_halts_it_in_real_time(make_cell):
    cell = make_cell()
    cell.clock.go_at(1)
    moving = asyncio.create_task(cell.move_robot([FAR_RAD], SLOW, np.zeros(3)))
    await asyncio.sleep(0)

    cell.add_fault(EmergencyStop())

    with pytest.raises(ArmStoppedError):
        await moving
    assert not cell.robot_moves


class Echo:
    """A server behind a cable, and a client of it."""

    def __init__(self):
        self.clock = CellClock(0)
        self.faults = Faults(lambda: self.clock.now_s)
        self.endpoint = Endpoint("robot-log", "echo", self._serve)
        self.endpoint.cable = FaultyCable("robot-log", self.faults, self.clock)

    async def _serve(self, reader, writer):
        while data := await reader.read(100):
            writer.write(data)
            await writer.drain()

    async def connect(self):
        return await asyncio.open_connection("127.0.0.1", (await self.endpoint.open("127.0.0.1", 0)).port)


@pytest.fixture
async def echo():
    made = Echo()
    yield made
    await made.endpoint.close()


async def talk(reader, writer, word):
    """Return the answer to a word, nothing where the far end hangs up; how it does is the system's choice."""
    try:
        writer.write(word)
        return await reader.read(100)
    except ConnectionError:
        return b""


async def test_a_cut_cable_breaks_what_was_connected_and_hangs_up_until_it_is_whole(echo):
    reader, writer = await echo.connect()
    before = await talk(reader, writer, b"one")
    echo.faults.add(LinkCut(device="robot", for_s=2.0))
    echo.faults.add(LinkCut(device="tracker"))
    broken = await talk(reader, writer, b"two")
    answers = []
    for _ in range(3):
        again = await asyncio.open_connection("127.0.0.1", echo.endpoint.port)
        answers.append(await talk(*again, b"three"))
        again[1].close()
    writer.close()

    assert (before, broken) == (b"one", b"")
    assert answers == [b"", b"", b"three"]  # an attempt costs a second of the cell
    assert echo.clock.now_s == 2.0


async def test_a_half_open_link_loses_every_word_and_is_unknown_to_the_far_end_afterwards(echo):
    reader, writer = await echo.connect()
    number = echo.faults.add(LinkHalfOpen(device="robot"))
    writer.write(b"lost")
    while echo.clock.now_s == 0.0:  # each word costs a second of the cell
        await asyncio.sleep(0.01)
    stays = not reader.at_eof()

    echo.faults.end(number)
    after = await talk(reader, writer, b"word")
    again = await asyncio.open_connection("127.0.0.1", echo.endpoint.port)
    found = await talk(*again, b"found")
    for end in (writer, again[1]):
        end.close()

    assert stays
    assert (after, found) == (b"", b"found")


def ask(cell, **request):
    return carry_out(json.dumps(request).encode(), _OPERATIONS, cell)


def test_an_engineer_is_told_every_kind_with_its_keys(make_cell):
    kinds = {kind["kind"]: kind["keys"] for kind in ask(make_cell(), op="kinds")["kinds"]}

    assert kinds.keys() == KINDS.keys()
    assert kinds["smr_missing"][0] == {"key": "nest", "type": "whole", "required": True}
    assert [key["key"] for key in kinds["beam_broken"]] == [
        *("from_s", "configuration", "move", "reading"),
        "count",
    ]


def test_an_engineer_gives_a_fault_sees_it_and_ends_it(make_cell):
    cell = make_cell()

    given = ask(cell, op="give", kind="smr_missing", nest=2)
    refused = ask(cell, op="give", kind="smr_missing", nest=9)
    (active,) = ask(cell, op="list")["faults"]
    ask(cell, op="end", number=given["number"])
    (over,) = ask(cell, op="list")["faults"]

    assert refused == {"error": 'key "nest" must be 1 to 3, not 9'}
    assert (active["kind"], active["keys"], active["state"]) == ("smr_missing", {"nest": 2}, "active")
    assert over["state"] == "over"
    assert ask(cell, op="end", number=7) == {"error": "there is no fault 7: 1 were given"}
    assert "whole number" in ask(cell, op="end", number="1")["error"]
