"""An emScon tracker's points, against a scripted server that lives in memory."""

import math

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    FakeTracker,
    answer,
    healthy,
    ready_tracker,
    single,
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


def test_it_is_a_point_tracker():
    tracker: PointTracker = tracker_on(FakeTracker())

    assert not tracker.connected


async def test_a_reading_carries_what_the_tracker_said():
    tracker = await ready_tracker(FakeTracker())

    reading = await tracker.measure_point(duration_s=1.0)

    assert reading.point_mm == (1.0, 2.0, 3.0)
    assert reading.standard_deviation_mm == (0.001, 0.002, 0.003)
    assert reading.rms_mm == 0.004
    assert (reading.face, reading.time_s, reading.duration_s) == (1, 12.5, 1.0)


@pytest.mark.parametrize("chunk_bytes", [1, 3, 4096])  # the result has 204 bytes
async def test_a_reading_survives_any_split_of_the_stream(chunk_bytes):
    tracker = await ready_tracker(
        FakeTracker(), chunk_bytes=chunk_bytes, time_outs=TimeOuts(initialise_s=5.0, command_s=5.0)
    )

    reading = await tracker.measure_point(duration_s=0.5)

    assert reading.point_mm == (1.0, 2.0, 3.0)


async def test_the_older_result_packet_is_taken_as_well():
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(PacketType.SINGLE_MEAS_RESULT, val1=4.0, val2=5.0, val3=6.0),
    ]
    tracker = await ready_tracker(fake)

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (4.0, 5.0, 6.0)


async def test_the_covariance_is_that_of_the_accuracy_model_and_absent_where_none_is_stated():
    fake = FakeTracker()
    stated = {"apriori_std1": 0.01, "apriori_std2": 0.02, "apriori_std3": 0.02, "apriori_covar12": 1e-5}
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(val1=1.0, val2=2.0, val3=3.0, **stated),
    ]
    tracker = await ready_tracker(fake)

    covariance = (await tracker.measure_point(duration_s=1.0)).covariance_mm2
    silent = (await (await ready_tracker(FakeTracker())).measure_point(duration_s=1.0)).covariance_mm2

    assert covariance == ((1e-4, 1e-5, 0.0), (1e-5, 4e-4, 0.0), (0.0, 0.0, 4e-4))
    assert silent is None


async def test_a_deviation_that_overflows_its_square_is_no_fault_of_the_program():
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(val1=1.0, val2=2.0, val3=3.0, apriori_std1=1e200, apriori_std2=0.01, apriori_std3=0.01),
    ]
    tracker = guarded("leica_emscon", "tracker", await ready_tracker(fake))

    with pytest.raises(ImplausibleReadingError, match="covariance"):
        await tracker.measure_point(duration_s=1.0)


async def test_an_older_tracker_without_statistic_modes_is_initialised_all_the_same():
    fake = FakeTracker()
    fake.script[Command.SET_STATISTIC_MODE] = lambda _: [
        Answer(Command.SET_STATISTIC_MODE, ResultStatus.NOT_IMPLEMENTED)
    ]

    tracker = await ready_tracker(fake)

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_unasked_packets_in_between_do_not_disturb_a_measurement():
    fake = FakeTracker()
    streamed = Result(PacketType.REFLECTOR_POS_RESULT, Record(val1=9.0, val2=9.0, val3=9.0))
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        StatusChange(SystemStatusChange.MEAS_STATUS_BUSY),
        streamed,
        answer(Command.START_MEASUREMENT),
        streamed,
        StatusChange(4711),
        single(val1=1.0, val2=2.0, val3=3.0),
        StatusChange(SystemStatusChange.MEAS_STATUS_READY),
        streamed,
    ]
    tracker = await ready_tracker(fake)

    points = [(await tracker.measure_point(duration_s=1.0)).point_mm for _ in range(2)]

    assert points == [(1.0, 2.0, 3.0)] * 2


async def test_a_result_that_was_under_way_before_the_question_is_not_taken():
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        single(val1=9.0, val2=9.0, val3=9.0),
        answer(Command.START_MEASUREMENT),
        single(val1=1.0, val2=2.0, val3=3.0),
    ]
    tracker = await ready_tracker(fake)

    points = [(await tracker.measure_point(duration_s=1.0)).point_mm for _ in range(3)]

    assert points == [(1.0, 2.0, 3.0)] * 3


async def test_a_result_of_an_earlier_measurement_is_not_taken_again():
    fake = FakeTracker()
    places = iter([(1.0, 2.0, 3.0), (500.0, 0.0, 0.0), (1.0, 2.0, 3.0)])
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(**dict(zip(("val1", "val2", "val3"), next(places), strict=True)), std_total=0.004),
    ]
    tracker = await ready_tracker(fake)
    await tracker.measure_point(duration_s=1.0)
    await tracker.measure_point(duration_s=1.0)
    fake.script[Command.GET_CURRENT_PRISM_POSITION] = lambda _: [
        answer(Command.GET_CURRENT_PRISM_POSITION, val1=500.0, val2=0.0, val3=0.0)
    ]

    with pytest.raises(RemoteProtocolError, match="earlier measurement again"):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


async def test_a_tracker_that_repeats_itself_and_sees_no_reflector_is_not_believed():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    await tracker.measure_point(duration_s=1.0)
    fake.script[Command.GET_CURRENT_PRISM_POSITION] = lambda request: [
        Answer(request.command, ResultStatus.NO_DISTANCE_SET)
    ]

    with pytest.raises(RemoteProtocolError, match="earlier measurement again"):
        await tracker.measure_point(duration_s=1.0)


@pytest.mark.parametrize("values", [{"meas_mode": 1}, {"is_try_mode": True}, {"std1": -0.1}])
async def test_a_result_that_is_no_stationary_point_closes_the_link(values):
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(val1=1.0, val2=2.0, val3=3.0, **values),
    ]
    tracker = await ready_tracker(fake)

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected


async def test_the_measuring_time_is_sent_when_it_changes_only():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)

    for duration_s in (1.0, 1.0, 2.5, 2.5):
        await tracker.measure_point(duration_s=duration_s)

    sent = [request.values["meas_time"] for request in fake.asked(Command.SET_STATIONARY_MODE_PARAMS)]
    assert sent == [1000, 2500]


async def test_finding_a_reflector_aims_there_and_searches_within_the_radius():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)

    await tracker.find_reflector((300.0, 0.0, 400.0), search_radius_mm=10.0)

    assert fake.asked(Command.SET_SEARCH_PARAMS)[0].values["search_radius"] == 10.0
    aim = fake.asked(Command.GO_POSITION)[0].values
    assert aim.vector() == (300.0, 0.0, 400.0)
    assert fake.asked(Command.FIND_REFLECTOR)[0].values == {"aprox_distance": 500.0}


@pytest.mark.parametrize("command", [Command.GO_POSITION, Command.FIND_REFLECTOR])
@pytest.mark.parametrize("kind", [Answer, ErrorReport])
async def test_an_empty_nest_is_reported_as_a_reflector_not_found(command, kind):
    fake = FakeTracker()
    fake.script[command] = lambda _: [kind(command, ResultStatus.NO_DISTANCE_SET)]
    tracker = await ready_tracker(fake)

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
async def test_a_broken_beam_is_reported_however_the_tracker_says_it(packets):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    fake.script[Command.START_MEASUREMENT] = lambda _: packets

    with pytest.raises(BeamBrokenError, match="line of sight"):
        await tracker.measure_point(duration_s=1.0)

    fake.script = healthy()
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_an_error_that_arrived_before_the_measurement_is_not_taken_for_its_own():
    fake = FakeTracker()
    stale = encode(ErrorReport(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET))
    face = encode(answer(Command.GET_FACE, tracker_face=1))
    fake.script[Command.GET_FACE] = lambda _: [face + stale]
    tracker = await ready_tracker(fake)

    points = [(await tracker.measure_point(duration_s=1.0)).point_mm for _ in range(2)]

    assert points == [(1.0, 2.0, 3.0)] * 2


@pytest.mark.parametrize(
    ("stated", "complaint"),
    [
        ({"val1": math.nan}, "no point"),
        ({"std2": -1.0}, "standard deviations"),
        ({"std2": math.inf}, "standard deviations"),
        ({"std_total": math.inf}, "standard deviations"),
    ],
)
async def test_a_point_that_is_none_is_refused(stated, complaint):
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(**stated),
    ]
    tracker = await ready_tracker(fake)

    with pytest.raises(RemoteProtocolError, match=complaint):
        await tracker.measure_point(duration_s=1.0)


async def test_the_face_is_changed_and_checked():
    fake = FakeTracker()
    fake.script[Command.GET_FACE] = lambda _: [
        answer(Command.GET_FACE, tracker_face=1 + len(fake.asked(Command.CHANGE_FACE)) % 2)
    ]
    tracker = await ready_tracker(fake)

    await tracker.change_face()

    assert (await tracker.measure_point(duration_s=1.0)).face == 2


async def test_a_tracker_that_stays_in_its_face_is_reported():
    tracker = await ready_tracker(FakeTracker())

    with pytest.raises(DeviceRefusedError, match="still stands in face 1"):
        await tracker.change_face()


@pytest.mark.parametrize("duration_s", [0.0, -1.0, float("nan"), float("inf")])
async def test_an_absurd_measuring_time_never_reaches_the_tracker(duration_s):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)

    with pytest.raises(ConfigurationError, match="measurement of"):
        await tracker.measure_point(duration_s=duration_s)

    assert fake.asked(Command.START_MEASUREMENT) == []


@pytest.mark.parametrize(
    ("near_mm", "radius_mm"),
    [((0.0, 0.0, 0.0), 1.0), ((float("nan"), 0.0, 1.0), 1.0), ((1.0, 0.0, 0.0), 0.0)],
)
async def test_an_absurd_search_never_reaches_the_tracker(near_mm, radius_mm):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)

    with pytest.raises(ConfigurationError):
        await tracker.find_reflector(near_mm, search_radius_mm=radius_mm)

    assert fake.asked(Command.GO_POSITION) == []


def test_the_fake_can_answer_every_command():
    assert set(EXCHANGES) <= set(healthy())


async def test_whoever_looks_on_is_told_where_the_reflector_is():
    fake = FakeTracker()
    tracker = tracker_on(fake)

    assert await tracker.reflector_now() is None  # not connected: nobody is asked
    tracker = guarded("leica_emscon", "tracker", await ready_tracker(fake))
    assert await tracker.reflector_now() == (1.0, 2.0, 3.0)

    fake.script[Command.GET_CURRENT_PRISM_POSITION] = lambda request: [
        Answer(request.command, ResultStatus.NO_DISTANCE_SET)
    ]
    assert await tracker.reflector_now() is None
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)
