"""An emScon tracker's points, against a scripted server that lives in memory."""

import math

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    FakeTracker,
    answer,
    answered,
    healthy,
    point,
    ready_tracker,
    refused,
    single,
    told,
    tracker_on,
)
from truepose_drivers.api import PointTracker
from truepose_drivers.errors import (
    BeamBrokenError,
    ConfigurationError,
    DeviceRefusedError,
    ImplausibleReadingError,
    ReflectorNotFoundError,
    RemoteProtocolError,
)
from truepose_drivers.guard import guarded
from truepose_drivers.leica_emscon.instrument import TimeOuts
from truepose_drivers.leica_emscon.protocol import (
    EXCHANGES,
    Answer,
    Command,
    ErrorReport,
    PacketType,
    Record,
    Result,
    ResultStatus,
    StatusChange,
    SystemStatusChange,
    encode,
)

pytestmark = pytest.mark.simulated_time

STREAMED = Result(PacketType.REFLECTOR_POS_RESULT, Record(val1=9.0, val2=9.0, val3=9.0))


async def test_a_reading_carries_what_the_tracker_said(tracker):
    as_api: PointTracker = tracker

    reading = await as_api.measure_point(duration_s=1.0)

    assert reading.point_mm == (1.0, 2.0, 3.0)
    assert reading.standard_deviation_mm == (0.001, 0.002, 0.003)
    assert reading.rms_mm == 0.004
    assert (reading.face, reading.time_s, reading.duration_s) == (1, 12.5, 1.0)
    assert reading.covariance_mm2 is None


@pytest.mark.parametrize("chunk_bytes", [1, 3, 4096])  # the result has 204 bytes
async def test_a_reading_survives_any_split_of_the_stream(chunk_bytes):
    tracker = await ready_tracker(
        FakeTracker(), chunk_bytes=chunk_bytes, time_outs=TimeOuts(initialise_s=5.0, command_s=5.0)
    )

    reading = await tracker.measure_point(duration_s=0.5)

    assert reading.point_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "packets",
    [
        [
            answer(Command.START_MEASUREMENT),
            single(PacketType.SINGLE_MEAS_RESULT, val1=1.0, val2=2.0, val3=3.0),
        ],
        [
            StatusChange(SystemStatusChange.MEAS_STATUS_BUSY),
            STREAMED,
            answer(Command.START_MEASUREMENT),
            STREAMED,
            StatusChange(4711),
            point(),
            StatusChange(SystemStatusChange.MEAS_STATUS_READY),
            STREAMED,
        ],
        [point(val1=9.0), answer(Command.START_MEASUREMENT), point()],  # under way before the question
    ],
    ids=["older packet", "unasked packets in between", "result of before"],
)
async def test_a_point_is_found_in_either_packet_among_whatever_else_comes(emscon, tracker, packets):
    emscon.script[Command.START_MEASUREMENT] = lambda _: packets

    points = [(await tracker.measure_point(duration_s=1.0)).point_mm for _ in range(3)]

    assert points == [(1.0, 2.0, 3.0)] * 3


async def test_the_covariance_is_that_of_the_accuracy_model(emscon, tracker):
    stated = {"apriori_std1": 0.01, "apriori_std2": 0.02, "apriori_std3": 0.02, "apriori_covar12": 1e-5}
    emscon.script[Command.START_MEASUREMENT] = answered(point(**stated))

    covariance = (await tracker.measure_point(duration_s=1.0)).covariance_mm2

    assert covariance == ((1e-4, 1e-5, 0.0), (1e-5, 4e-4, 0.0), (0.0, 0.0, 4e-4))


async def test_a_deviation_that_overflows_its_square_is_no_fault_of_the_program(emscon, tracker):
    overflowing = point(apriori_std1=1e200, apriori_std2=0.01, apriori_std3=0.01)
    emscon.script[Command.START_MEASUREMENT] = answered(overflowing)

    with pytest.raises(ImplausibleReadingError, match="covariance"):
        await guarded("leica_emscon", "tracker", tracker).measure_point(duration_s=1.0)


async def test_an_older_tracker_without_statistic_modes_is_initialised_all_the_same(emscon):
    emscon.script[Command.SET_STATISTIC_MODE] = refused()

    tracker = await ready_tracker(emscon)

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("sees", [told(val1=500.0), refused(ResultStatus.NO_DISTANCE_SET)])
async def test_a_result_of_an_earlier_measurement_is_not_taken_again(emscon, tracker, sees):
    places = iter([1.0, 500.0, 1.0])
    emscon.script[Command.START_MEASUREMENT] = lambda request: [
        answer(request.command),
        point(val1=next(places)),
    ]
    await tracker.measure_point(duration_s=1.0)
    await tracker.measure_point(duration_s=1.0)
    emscon.script[Command.GET_CURRENT_PRISM_POSITION] = sees

    with pytest.raises(RemoteProtocolError, match="earlier measurement again"):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


@pytest.mark.parametrize(
    ("stated", "complaint"),
    [
        ({"meas_mode": 1}, "a mode other"),
        ({"is_try_mode": True}, "a mode other"),
        ({"val1": math.nan}, "not a valid point"),
        ({"std1": -0.1}, "standard deviations"),
        ({"std2": -1.0}, "standard deviations"),
        ({"std2": math.inf}, "standard deviations"),
        ({"std_total": math.inf}, "standard deviations"),
    ],
)
async def test_a_result_that_is_no_stationary_point_closes_the_link(emscon, tracker, stated, complaint):
    emscon.script[Command.START_MEASUREMENT] = answered(point(**stated))

    with pytest.raises(RemoteProtocolError, match=complaint):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


async def test_the_measuring_time_is_sent_when_it_changes_only(emscon, tracker):
    for duration_s in (1.0, 1.0, 2.5, 2.5):
        await tracker.measure_point(duration_s=duration_s)

    sent = [request.values["meas_time"] for request in emscon.asked(Command.SET_STATIONARY_MODE_PARAMS)]
    assert sent == [1000, 2500]


async def test_finding_a_reflector_aims_there_and_searches_within_the_radius(emscon, tracker):
    await tracker.find_reflector((300.0, 0.0, 400.0), search_radius_mm=10.0)

    assert emscon.asked(Command.SET_SEARCH_PARAMS)[0].values["search_radius"] == 10.0
    assert emscon.asked(Command.GO_POSITION)[0].values.vector() == (300.0, 0.0, 400.0)
    assert emscon.asked(Command.FIND_REFLECTOR)[0].values == {"aprox_distance": 500.0}


@pytest.mark.parametrize("command", [Command.GO_POSITION, Command.FIND_REFLECTOR])
@pytest.mark.parametrize("kind", [Answer, ErrorReport])
async def test_an_empty_nest_is_reported_as_a_reflector_not_found(emscon, tracker, command, kind):
    emscon.script[command] = lambda _: [kind(command, ResultStatus.NO_DISTANCE_SET)]

    with pytest.raises(ReflectorNotFoundError, match="sits in its nest"):
        await tracker.find_reflector((300.0, 0.0, 400.0), search_radius_mm=10.0)

    assert tracker.connected  # the dialogue is in step: nothing to reconnect


@pytest.mark.parametrize(
    "packets",
    [
        [ErrorReport(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET)],
        [Answer(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET)],
        [answer(Command.START_MEASUREMENT), ErrorReport(49, ResultStatus.UNKNOWN)],
        [answer(Command.START_MEASUREMENT), ErrorReport(0, ResultStatus.WRONG_CURRENT_REFLECTOR)],
        [answer(Command.START_MEASUREMENT), single(status=ResultStatus.NO_STATIONARY_RESULT)],
    ],
)
async def test_a_broken_beam_is_reported_however_the_tracker_says_it(emscon, tracker, packets):
    emscon.script[Command.START_MEASUREMENT] = lambda _: packets

    with pytest.raises(BeamBrokenError, match="line of sight"):
        await tracker.measure_point(duration_s=1.0)

    emscon.script = healthy()
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_an_error_that_arrived_before_the_measurement_is_not_taken_for_its_own(emscon, tracker):
    stale = encode(ErrorReport(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET))
    face = encode(answer(Command.GET_FACE, tracker_face=1))
    emscon.script[Command.GET_FACE] = lambda _: [face + stale]

    points = [(await tracker.measure_point(duration_s=1.0)).point_mm for _ in range(2)]

    assert points == [(1.0, 2.0, 3.0)] * 2


async def test_the_face_is_changed_and_checked(emscon, tracker):
    emscon.script[Command.GET_FACE] = lambda request: [
        answer(request.command, tracker_face=1 + len(emscon.asked(Command.CHANGE_FACE)) % 2)
    ]

    await tracker.change_face()

    assert (await tracker.measure_point(duration_s=1.0)).face == 2


async def test_a_tracker_that_stays_in_its_face_is_reported(tracker):
    with pytest.raises(DeviceRefusedError, match="still stands in face 1"):
        await tracker.change_face()


@pytest.mark.parametrize(
    ("use", "numbers"),
    [
        *(("measure_point", {"duration_s": duration_s}) for duration_s in (0.0, -1.0, math.nan, math.inf)),
        ("find_reflector", {"near_mm": (0.0, 0.0, 0.0), "search_radius_mm": 1.0}),
        ("find_reflector", {"near_mm": (math.nan, 0.0, 1.0), "search_radius_mm": 1.0}),
        ("find_reflector", {"near_mm": (1.0, 0.0, 0.0), "search_radius_mm": 0.0}),
    ],
)
async def test_an_absurd_measurement_or_search_never_reaches_the_tracker(emscon, tracker, use, numbers):
    with pytest.raises(ConfigurationError):
        await getattr(tracker, use)(**numbers)

    assert emscon.asked(Command.START_MEASUREMENT) + emscon.asked(Command.GO_POSITION) == []


def test_the_fake_can_answer_every_command():
    assert set(EXCHANGES) <= set(healthy())


async def test_whoever_looks_on_is_told_where_the_reflector_is(emscon):
    tracker = tracker_on(emscon)

    assert await tracker.reflector_now() is None  # not connected: nobody is asked
    tracker = guarded("leica_emscon", "tracker", await ready_tracker(emscon))
    assert await tracker.reflector_now() == (1.0, 2.0, 3.0)

    emscon.script[Command.GET_CURRENT_PRISM_POSITION] = refused(ResultStatus.NO_DISTANCE_SET)
    assert await tracker.reflector_now() is None
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)
