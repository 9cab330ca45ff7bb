"""The conversation with an emScon server: silence, garbage, refusals and lost links."""

import asyncio

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    HANG_UP,
    SILENT,
    FakeTracker,
    Slow,
    answer,
    answered,
    healthy,
    ready_tracker,
    refused,
    told,
    tracker_on,
)
from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.errors import (
    BusyError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    MeasurementFailedError,
    NoReplyError,
    NotInitialisedError,
    RemoteProtocolError,
)
from truepose_drivers.leica_emscon.driver import LaserTracker
from truepose_drivers.leica_emscon.error_codes import error_for
from truepose_drivers.leica_emscon.instrument import TimeOuts
from truepose_drivers.leica_emscon.protocol import (
    Answer,
    Command,
    ErrorReport,
    PacketType,
    Record,
    Result,
    ResultStatus,
    encode,
)

pytestmark = pytest.mark.simulated_time


@pytest.mark.parametrize("status", list(ResultStatus)[1:])
@pytest.mark.parametrize("purpose", ["set", "find", "measure"])
async def test_every_status_has_a_sentence(status, purpose):
    sentence = str(error_for(Command.GO_POSITION, status, purpose))

    assert "GO_POSITION" in sentence
    assert ":" in sentence or "value of" in sentence


async def test_a_tracker_in_use_by_another_program_says_so():
    fake = FakeTracker(hello=(ErrorReport(0, ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED),))
    tracker = tracker_on(fake)

    with pytest.raises(DeviceRefusedError, match="another program is connected"):
        await tracker.connect()
    assert not tracker.connected


async def test_a_stream_of_positions_does_not_hide_that_the_answer_is_missing():
    async def chatter(end: MemoryEnd) -> None:
        while True:
            await end.send(encode(Result(PacketType.REFLECTOR_POS_RESULT, Record(val1=0, val2=0, val3=0))))
            await asyncio.sleep(0.001)

    tracker = LaserTracker(MemoryLink(chatter), FixedClock(), time_outs=SILENT)

    async with asyncio.timeout(60.0):
        with pytest.raises(ConnectFailedError, match="GET_SYSTEM_STATUS"):
            await tracker.connect()


async def test_it_can_be_connected_again_after_a_loss_and_wants_initialising(emscon, tracker):
    emscon.script[Command.START_MEASUREMENT] = lambda _: [HANG_UP]
    with pytest.raises(ConnectionLostError):
        await tracker.measure_point(duration_s=1.0)
    with pytest.raises(ConnectionLostError, match="connect first"):
        await tracker.measure_point(duration_s=1.0)
    emscon.script = healthy()

    await tracker.connect()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_point(duration_s=1.0)
    await tracker.initialise()

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_closing_twice_or_before_connecting_is_harmless():
    tracker = tracker_on(FakeTracker())

    await tracker.close()
    await tracker.connect()
    await tracker.close()
    await tracker.close()

    assert not tracker.connected


@pytest.mark.parametrize(
    ("status", "error", "advice"),
    [
        (ResultStatus.SERVER_BUSY, BusyError, "wait"),
        (ResultStatus.SENSOR_NOT_WARMED_UP, BusyError, "warmed up"),
        (ResultStatus.TRACKER_NOT_INITIALIZED, NotInitialisedError, "initialise it first"),
        (ResultStatus.WRONG_PARAMETER_1, DeviceRefusedError, "value of START_MEASUREMENT"),
        (ResultStatus.NOT_IMPLEMENTED, DeviceRefusedError, "does not support"),
        (ResultStatus.SENSOR_NOT_LEVELED, DeviceRefusedError, "level the stand"),
        (ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED, DeviceRefusedError, "another program"),
        (123_456, MeasurementFailedError, r"123456 \(unknown"),
    ],
)
async def test_a_status_becomes_an_error_with_advice(emscon, tracker, status, error, advice):
    emscon.script[Command.START_MEASUREMENT] = refused(status)

    with pytest.raises(error, match=advice):
        await tracker.measure_point(duration_s=1.0)


USES = {
    Command.INITIALIZE: lambda tracker: tracker.initialise(),
    Command.SET_SYSTEM_SETTINGS: lambda tracker: tracker.initialise(),
    Command.GO_POSITION: lambda tracker: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0),
    Command.FIND_REFLECTOR: lambda tracker: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0),
    Command.CHANGE_FACE: lambda tracker: tracker.change_face(),
    Command.START_MEASUREMENT: lambda tracker: tracker.measure_point(duration_s=5.0),
    Command.GET_ENVIRONMENT_PARAMS: lambda tracker: tracker.environment(),
    Command.GET_SYSTEM_STATUS: lambda tracker: tracker.identify(),
}


@pytest.fixture
async def patient(emscon):
    """A tracker whose driver allows it as much time as a real one."""
    return await ready_tracker(emscon, time_outs=TimeOuts())


async def seconds_of(use) -> float:
    loop = asyncio.get_running_loop()
    begun_s = loop.time()
    with pytest.raises(NoReplyError):
        await use
    return loop.time() - begun_s


@pytest.mark.parametrize("command", USES)
async def test_a_half_open_link_is_lost_within_two_seconds_whatever_was_asked(emscon, patient, command):
    started = {"tracker_processor_status": 3 if command == Command.INITIALIZE else 5}
    emscon.script[Command.GET_SYSTEM_STATUS] = told(**started)
    emscon.dies_at = command

    assert await seconds_of(USES[command](patient)) <= 2.0
    assert not patient.connected


async def test_a_link_that_dies_while_the_tracker_measures_is_lost_within_two_seconds(emscon, patient):
    emscon.script[Command.START_MEASUREMENT] = answered()
    emscon.dies_at = Command.GET_TRACKER_STATUS

    assert await seconds_of(patient.measure_point(duration_s=30.0)) <= 2.0


async def test_a_tracker_that_says_that_it_is_busy_is_waited_for(emscon, patient):
    emscon.script[Command.FIND_REFLECTOR] = lambda request: [Slow(20.0, [answer(request.command)])]

    await patient.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0)

    assert len(emscon.asked(Command.GET_TRACKER_STATUS)) > 10
    assert (await patient.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_a_tracker_that_queues_what_it_is_asked_is_waited_for_in_silence(emscon):
    queue = answer(Command.GET_LONG_SYSTEM_PARAMETER, system_param=200, parameter=3)
    emscon.script[Command.GET_LONG_SYSTEM_PARAMETER] = lambda _: [queue]
    emscon.says_busy = False
    tracker = await ready_tracker(emscon, time_outs=TimeOuts())
    emscon.script[Command.FIND_REFLECTOR] = lambda request: [Slow(20.0, [answer(request.command)])]

    await tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0)

    assert emscon.asked(Command.GET_TRACKER_STATUS) == []


async def test_a_sign_of_life_that_comes_behind_the_answer_is_no_answer_too_many(emscon, patient):
    late = Answer(Command.GET_TRACKER_STATUS, ResultStatus.SERVER_BUSY)
    emscon.script[Command.FIND_REFLECTOR] = lambda request: [Slow(1.0, [answer(request.command), late])]
    emscon.says_busy = False

    await patient.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0)

    assert len(emscon.asked(Command.GET_TRACKER_STATUS)) == 1
    assert (await patient.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_a_status_that_nobody_asked_for_is_an_answer_too_many(emscon, patient):
    status = answer(Command.GET_TRACKER_STATUS)
    emscon.script[Command.GET_FACE] = lambda request: [
        encode(answer(request.command, tracker_face=1)) + encode(status)
    ]

    with pytest.raises(RemoteProtocolError, match="more data than requested"):
        await patient.measure_point(duration_s=1.0)


@pytest.mark.parametrize("command", [Command.GET_ENVIRONMENT_PARAMS, Command.START_MEASUREMENT])
async def test_an_answer_that_was_lost_is_not_waited_for_where_the_tracker_is_there(emscon, patient, command):
    emscon.script[command] = lambda _: []

    assert await seconds_of(USES[command](patient)) <= 2.0
    assert not patient.connected


async def test_a_result_that_a_living_tracker_never_sends_is_waited_for_ten_seconds_longer(emscon, patient):
    emscon.script[Command.START_MEASUREMENT] = answered()

    assert await seconds_of(patient.measure_point(duration_s=2.0)) == pytest.approx(12.0, abs=0.1)
