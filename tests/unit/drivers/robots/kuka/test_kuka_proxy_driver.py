"""The conversation with a variable proxy, against a scripted controller that lives in memory."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.kuka_variable_proxy.driver import KukaRobot
from truepose_drivers.kuka_variable_proxy.protocol import (
    Answer,
    Mode,
    ProgramState,
    RequestReader,
    decode_axes,
    encode_answer,
    encode_axes,
    encode_state,
)

pytestmark = pytest.mark.simulated_time

TARGET_DEG = (10.0, -20.0, 50.0, 1.0, 2.0, 3.0)
TARGET = tuple(map(math.radians, TARGET_DEG))
HOME_DEG = (0.0, -90.0, 90.0, 0.0, 0.0, 0.0, 7.5, 0.0, 0.0, 0.0, 0.0, 0.0)
SILENT = HANG_UP = None


class FakeController:
    """Variables in a table; arrives at once, unless `on_order` says otherwise."""

    def __init__(self, **changes):
        self.variables = {
            "PING": "PONG",
            "$AXIS_ACT": encode_axes(HOME_DEG, "E6AXIS"),
            "$OV_PRO": "100",
            "$PRO_STATE1": "#P_ACTIVE",
            "$PERI_RDY": "TRUE",
            "$KR_SERIALNO": "482915",
            "$MODEL_NAME[]": '"#KR6R900 Z200 C4SR FLR"',
            "$RCV_INFO[]": '"KS V8.3.27"',
            "TP_STATE": encode_state(ProgramState(4, 4, 0, 0)),
            "TP_NUMBER": "4",
            "TP_TARGET": encode_axes(HOME_DEG, "E6AXIS"),
            "TP_PERCENT": "1",
            "TP_OVERRIDE": "1",
            "TP_BEAT": "0",
        } | changes
        self.on_order = self.arrive
        self.spoil = None  # of every answer: a function of request and answer
        self.asked = []
        self.written = []
        self.ends = []

    def arrive(self, number):
        self.variables["$AXIS_ACT"] = encode_axes(decode_axes(self.variables["TP_TARGET"]), "E6AXIS")
        self.say(begun=number, arrived=number)

    def say(self, **changes):
        state = ProgramState(4, 4, 0, 0)
        self.variables["TP_STATE"] = encode_state(replace(state, **changes))

    def values(self, name):
        return [value for written, value in self.written if written == name]

    async def serve(self, end: MemoryEnd) -> None:
        self.ends.append(end)
        reader = RequestReader()
        while data := await end.receive():
            reader.receive_data(data)
            while (request := reader.next_message()) is not None:
                answer = self.answer(request)
                said = encode_answer(answer) if self.spoil is None else self.spoil(request, answer)
                if said is SILENT:
                    continue
                await end.send(said)

    def answer(self, request):
        self.asked.append(request.name)
        if request.value is None:
            return Answer(request.number, Mode.READ, self.variables.get(request.name, ""), True)
        self.written.append((request.name, request.value))
        known = request.name in self.variables
        if known:
            self.variables[request.name] = request.value
            if request.name == "TP_NUMBER":
                self.on_order(int(request.value))
        return Answer(request.number, Mode.WRITE, request.value, known)


async def connected(fake, chunk_bytes=4096, **changes):
    robot = KukaRobot(MemoryLink(fake.serve, chunk_bytes=chunk_bytes), FixedClock(), **changes)
    await robot.connect()
    return robot


@pytest.fixture
def fake():
    return FakeController()


@pytest.fixture
async def robot(fake):
    return await connected(fake)


@pytest.mark.parametrize("chunk_bytes", [1, 7, 4096])
async def test_a_target_goes_out_and_comes_back(fake, chunk_bytes):
    robot = await connected(fake, chunk_bytes)

    await robot.move_joints(TARGET)
    reading = await robot.read_joints()

    assert decode_axes(fake.variables["TP_TARGET"]) == pytest.approx((*TARGET_DEG, *HOME_DEG[6:]))
    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-7)
    assert math.degrees(reading.resolution_rad) == pytest.approx(3.05e-5, rel=0.01)
    assert reading.time_s == 12.5


async def test_joints_that_are_counted_the_other_way_round_are_turned_both_ways(fake):
    robot = await connected(fake, signs=(-1, 1, 1, -1, 1, -1))

    await robot.move_joints(TARGET)

    assert decode_axes(fake.variables["TP_TARGET"])[:6] == pytest.approx((
        -10.0,
        -20.0,
        50.0,
        -1.0,
        2.0,
        -3.0,
    ))
    assert (await robot.read_joints()).joints_rad == pytest.approx(TARGET, abs=1e-7)


async def test_the_number_is_written_last_and_is_a_new_one(fake, robot):
    await robot.move_joints(TARGET)

    names = [name for name, _ in fake.written]
    assert names == ["TP_TARGET", "TP_PERCENT", "TP_OVERRIDE", "TP_NUMBER", "TP_BEAT"]
    assert fake.values("TP_NUMBER") == ["5"]


async def test_a_motion_keeps_the_limits_by_share_and_override(fake, robot):
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    await robot.move_joints(tuple(map(math.radians, (90.0, *HOME_DEG[1:6]))))

    assert fake.values("TP_PERCENT") == ["1"]
    assert fake.values("TP_OVERRIDE") == ["55"]  # 2 of 3.6 deg/s


async def test_an_override_that_somebody_lowered_is_left_as_it_is():
    fake = FakeController(**{"$OV_PRO": "10"})
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    await robot.move_joints(TARGET)

    assert fake.values("TP_OVERRIDE") == ["10"]
    assert fake.values("$OV_PRO") == []


async def test_beats_differ_for_as_long_as_the_arm_moves(fake, robot):
    fake.on_order = lambda number: fake.say(begun=number)

    moving = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(2.0)
    beats = fake.values("TP_BEAT")
    fake.arrive(5)
    await moving

    assert len(set(beats)) == len(beats) > 20


async def test_an_abandoned_motion_is_heard_of_no_more(fake, robot):
    fake.on_order = lambda number: fake.say(begun=number)
    moving = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(1.0)

    moving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await moving
    beats = len(fake.values("TP_BEAT"))
    await asyncio.sleep(5.0)

    assert len(fake.values("TP_BEAT")) == beats
    await robot.close()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"$PRO_STATE1": "#P_STOP"}, "no program runs.*TRUEPOSE.*confirm"),
        ({"$PRO_STATE1": "#P_FREE"}, "no program runs.*TRUEPOSE.*confirm"),
        ({"$PERI_RDY": "FALSE"}, "drives.*TRUEPOSE.*confirm"),
        ({"TP_STATE": ""}, "not on the controller.*TRUEPOSE.*confirm"),
        ({"TP_STATE": encode_state(ProgramState(5, 4, 0, 0))}, "still moving"),
    ],
)
async def test_a_controller_that_is_not_ready_is_not_moved_and_says_why(changes, words):
    fake = FakeController(**changes)
    robot = await connected(fake)

    with pytest.raises(NotInitialisedError, match=words):
        await robot.move_joints(TARGET)
    assert fake.written == []
    assert (await robot.read_joints()).joints_rad


@pytest.mark.parametrize(
    ("said", "error", "complaint", "keeps_link"),
    [
        (["begun", "given_up"], ConnectionLostError, r"0\.8 s", True),
        ([], NotInitialisedError, "did not begin", True),  # another program runs
        (["begun"], NoReplyError, "not reach its target in time", False),
        (["begun", "arrived"], RemoteProtocolError, r"70\.000 deg off", False),
    ],
)
async def test_a_motion_that_does_not_end_at_its_target_is_told(
    fake, robot, said, error, complaint, keeps_link
):
    fake.on_order = lambda number: fake.say(**dict.fromkeys(said, number))

    with pytest.raises(error, match=complaint):
        await robot.move_joints(TARGET)
    assert robot.connected == keeps_link


async def test_a_refused_target_is_named_as_the_pendant_shows_it(fake, robot):
    fake.on_order = lambda number: fake.say(begun=number, refused=number)

    with pytest.raises(TargetRefusedError, match=r"10\.000, -20\.000, 50\.000.*pendant.*ranges"):
        await robot.move_joints(TARGET)
    fake.on_order = fake.arrive
    await robot.move_joints(TARGET)

    assert fake.values("TP_NUMBER") == ["5", "6"]


async def test_a_program_that_is_stopped_on_the_way_is_told(fake, robot):
    fake.on_order = lambda number: fake.say(begun=number)
    moving = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(1.0)

    fake.variables["$PRO_STATE1"] = "#P_STOP"

    with pytest.raises(NotInitialisedError, match=r"stopped during the motion \(#P_STOP\)"):
        await moving


async def test_variables_that_do_not_keep_what_is_written_move_nothing(fake, robot):
    fake.spoil = lambda request, answer: encode_answer(
        replace(answer, value="99") if request.name == "TP_PERCENT" and request.value is None else answer
    )

    with pytest.raises(RemoteProtocolError, match="does not keep"):
        await robot.move_joints(TARGET)
    assert fake.values("TP_NUMBER") == []


async def test_an_idle_proxy_is_pinged_before_it_hangs_up(fake, robot):
    await asyncio.sleep(65.0)

    assert fake.asked.count("PING") == 6
    assert robot.connected
    await robot.close()
    await asyncio.sleep(60.0)
    assert fake.asked.count("PING") == 6


async def test_a_proxy_that_dies_while_nobody_asks_is_missed(fake, robot):
    fake.spoil = lambda request, answer: SILENT

    await asyncio.sleep(15.0)

    assert not robot.connected


async def test_connecting_again_is_not_disturbed_by_a_ping_under_way(fake, robot):
    fake.spoil = lambda request, answer: SILENT
    await asyncio.sleep(10.5)  # a ping waits for its answer
    fake.spoil = None

    await robot.connect()
    await asyncio.sleep(5.0)

    assert robot.connected
    assert (await robot.read_joints()).joints_rad
    await robot.close()


async def test_what_older_software_does_not_tell_is_unknown():
    fake = FakeController(**{"$RCV_INFO[]": "", "$MODEL_NAME[]": '""'})

    identity = await (await connected(fake)).identify()

    assert (identity.model, identity.firmware) == ("unknown", "unknown")


async def test_whoever_has_no_axes_is_no_robot():
    robot = KukaRobot(MemoryLink(FakeController(**{"$AXIS_ACT": ""}).serve), FixedClock())

    with pytest.raises(ConnectFailedError, match="KUKA controller"):
        await robot.connect()
    assert not robot.connected


async def test_a_variable_that_cannot_be_written_is_named(fake):
    del fake.variables["TP_PERCENT"]
    robot = await connected(fake)

    with pytest.raises(DeviceRefusedError, match="TP_PERCENT"):
        await robot.move_joints(TARGET)
    assert robot.connected


async def test_two_motions_at_once_go_one_after_the_other(fake, robot):
    await asyncio.gather(robot.move_joints(TARGET), robot.move_joints((0.0,) * 6))

    assert fake.values("TP_NUMBER") == ["5", "6"]
    assert decode_axes(fake.variables["$AXIS_ACT"])[:6] == (0.0,) * 6


async def test_more_than_was_asked_closes_the_link(fake, robot):
    fake.spoil = lambda request, answer: encode_answer(answer) * 2

    with pytest.raises(RemoteProtocolError, match="more data than requested"):
        await robot.read_joints()
    assert not robot.connected
