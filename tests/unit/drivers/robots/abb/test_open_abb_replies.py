"""Replies of an open_abb server, whole and in parts."""

import asyncio
import math

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from tests.unit.drivers.robots.abb.open_abb_server import (
    FAST,
    TARGET,
    FakeController,
    connected_robot,
)
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot
from truepose_drivers.abb_open_abb.protocol import (
    REPLY_RESOLUTION_DEG,
)
from truepose_drivers.errors import (
    NoReplyError,
    RemoteProtocolError,
)

pytestmark = pytest.mark.simulated_time


@pytest.mark.parametrize("chunk_bytes", [1, 5, 4096])
async def test_joints_survive_any_split_of_the_stream(chunk_bytes):
    robot = await connected_robot(FakeController(), chunk_bytes)

    reading = await robot.read_joints()

    assert tuple(map(math.degrees, reading.joints_rad)) == pytest.approx((10, -20.55, 30, 0, 45, -0.01))
    assert math.degrees(reading.resolution_rad) == pytest.approx(REPLY_RESOLUTION_DEG)
    assert reading.time_s == 12.5


@pytest.mark.parametrize("chunk_bytes", [1, 4096])
async def test_whole_degrees_may_come_without_decimals(chunk_bytes):
    robot = await connected_robot(FakeController(code_4="4 1 10 -20.5 30 0 45 90"), chunk_bytes)

    reading = await robot.read_joints()

    assert tuple(map(math.degrees, reading.joints_rad)) == pytest.approx((10, -20.5, 30, 0, 45, 90))


@pytest.mark.parametrize("chunk_bytes", [1, 4096])
async def test_a_server_that_gives_more_decimals_is_read_to_its_own_resolution(chunk_bytes):
    fake = FakeController(code_4="4 1 10.12345 -20.55000 30 0.1 45.00000 90.12345")
    robot = await connected_robot(fake, chunk_bytes)

    reading = await robot.read_joints()

    assert math.degrees(reading.joints_rad[5]) == pytest.approx(90.12345, abs=1e-9)
    assert math.degrees(reading.resolution_rad) == pytest.approx(1e-5)


@pytest.mark.parametrize(
    ("begun", "rest", "last_deg"),
    [
        ("4 1 10.00 -20.55 30.00 0.00 45.00 -0.0", "1", -0.01),
        ("4 1 10.00 -20.55 30.00 0.00 45.00 9", "0.12", 90.12),
        ("4 1 10 20 30 0 45 1", "80.25", 180.25),
        ("4 1 0 0 0 0 0 10.12", "345", 10.12345),
        ("4 1 10.00 -20.55 30.00 0.00 45.00 9", "1.00 ", 91.0),
    ],
)
async def test_a_line_that_stalls_inside_a_number_ends_none(begun, rest, last_deg):
    class Stalling(FakeController):
        async def say(self, end: MemoryEnd, reply: str) -> None:
            if reply.startswith(begun):
                await end.send(begun.encode())
                await asyncio.sleep(0.05)  # longer than the driver waits for the rest of a reply
                reply = rest
            await end.send(reply.encode())

    robot = OpenAbbRobot(MemoryLink(Stalling(code_4=begun + rest).serve), FixedClock())
    await robot.connect()

    assert math.degrees((await robot.read_joints()).joints_rad[5]) == pytest.approx(last_deg)
    await robot.close()


STATED = "10.00 -20.55 30.00 0.00 45.00 -0.01"


@pytest.mark.parametrize(
    "bad",
    [
        "10.00 -20.55 30.00 0.00 45.00 -0.0",  # a digit lost at the end
        "10.00 -20.55 30.00 0.00 45.00 -0",
        "10.00 -20.555 30.00 0.00 45.00 -0.01",  # one came twice
    ],
)
async def test_digits_that_were_lost_or_came_twice_are_found_by_asking_again(fake, bad):
    said = iter([STATED, STATED, bad, STATED])
    fake.replies[4] = Said(lambda: f"4 1 {next(said)}")
    robot = await connected_robot(fake)

    for _ in range(2):
        reading = await robot.read_joints()
        assert math.degrees(reading.joints_rad[1]) == pytest.approx(-20.55)
        assert math.degrees(reading.joints_rad[5]) == pytest.approx(-0.01)


async def test_joints_of_which_nobody_can_tell_whether_they_are_whole_close_the_link(fake):
    said = iter(["10 20 30 0 45 9", "10 20 30 0 45 90"])
    fake.replies[4] = Said(lambda: f"4 1 {next(said)}")
    robot = await connected_robot(fake)

    with pytest.raises(RemoteProtocolError, match="lost or duplicated"):
        await robot.read_joints()
    assert not robot.connected


class Said:
    """A reply that is another one each time."""

    def __init__(self, text) -> None:
        self._text = text

    def __str__(self) -> str:
        return self._text()


async def test_a_reply_whose_end_cannot_be_told_is_none_where_the_ping_stays_without_reply():
    fake = FakeController(code_4="4 1 10 20 30 0 45 90")
    robot = await connected_robot(fake)
    fake.replies[0] = ""

    with pytest.raises(NoReplyError, match="did not complete its reply"):
        await robot.read_joints()
    assert not robot.connected


@pytest.mark.parametrize(
    "reply",
    [
        "4 1 10.00 -20.55 30.00 0.00 45.00 -0.01 7.00",
        "4 1 10.00 -20.55 30.00 0.00 45.00 3600.01",
        "4 1 10.00 -20.55 30.00 0.00 45.00 9E+09",
        "4 1 10.00 -20.55 nan 0.00 45.00 -0.01",
        "4 7 10.00 -20.55 30.00 0.00 45.00 -0.01",
        "4 1 10.00 -20.55 30.00 0.00 45.00 -0.014 1 10.00 -20.55 30.00 0.00 45.00 -0.01",
    ],
)
async def test_joints_that_are_none_close_the_link(reply):
    robot = await connected_robot(FakeController(code_4=reply))

    with pytest.raises(RemoteProtocolError):
        await robot.read_joints()
    assert not robot.connected


async def test_a_reply_that_goes_on_is_none_to_a_motion():
    robot = await connected_robot(FakeController(code_8="8 1 9 1 "))

    with pytest.raises(RemoteProtocolError, match="continues with"):
        await robot.set_limits(FAST)
    assert not robot.connected


async def test_a_reply_without_its_trailing_space_is_taken():
    robot = await connected_robot(FakeController(code_2="2 1", code_8="8 1", code_9="9 1\r\n"))
    await robot.set_limits(FAST)

    await robot.move_joints(TARGET)

    assert robot.connected


async def test_an_identity_that_lacks_fields_says_unknown():
    robot = await connected_robot(FakeController(code_98="98 1 120-500123"))

    identity = await robot.identify()

    assert (identity.serial, identity.firmware, identity.model) == ("120-500123", "unknown", "unknown")
