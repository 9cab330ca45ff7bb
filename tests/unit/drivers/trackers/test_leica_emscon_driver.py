"""The laser tracker's conversation, against a scripted server that lives in memory."""

import asyncio
import struct
from collections.abc import Callable

import pytest

from truepose_drivers.api import PointTracker
from truepose_drivers.errors import (
    BeamBrokenError,
    BusyError,
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    ImplausibleReadingError,
    MeasurementFailedError,
    NoReplyError,
    NotInitialisedError,
    ReflectorNotFoundError,
    RemoteProtocolError,
)
from truepose_drivers.guard import guarded
from truepose_drivers.leica_emscon.driver import LaserTracker, TimeOuts
from truepose_drivers.leica_emscon.protocol import (
    EXCHANGES,
    RESULTS,
    Answer,
    Command,
    ErrorReport,
    FrameReader,
    PacketType,
    Record,
    Request,
    Result,
    ResultStatus,
    StatusChange,
    SystemStatusChange,
    decode_request,
    encode,
    exchange,
)
from truepose_drivers.leica_emscon.sentences import error_for
from truepose_drivers.transports.memory import MemoryEnd, MemoryLink

pytestmark = pytest.mark.simulated_time

Script = dict[int, Callable[[Request], list[object]]]

SILENT = TimeOuts(initialise_s=0.05, command_s=0.05)  # the fake answers at once or never
HANG_UP = object()


def answer(command: int, **values) -> Answer:
    filled = exchange(command).answer.zeros() | values
    return Answer(command, ResultStatus.ALL_OK, Record(filled))


def single(packet_type: int = PacketType.SINGLE_MEAS_RESULT_2, status: int = 0, **values) -> Result:
    return Result(packet_type, Record(RESULTS[packet_type].zeros() | values), status)


def reflector(number: int, name: str, total: int = 1) -> Answer:
    return answer(
        Command.GET_REFLECTORS,
        total_reflectors=total,
        internal_reflector_id=number,
        reflector_name=name,
    )


def as_set(request: Request) -> list[object]:
    """Answer a question with what was set, where the tracker remembers it; with zeros otherwise."""
    return [answer(request.command)]


def healthy() -> Script:
    """A tracker that is started up, knows one reflector and measures (1, 2, 3)."""
    script: Script = dict.fromkeys(Command, as_set)
    script[Command.GET_SYSTEM_STATUS] = lambda _: [
        answer(
            Command.GET_SYSTEM_STATUS,
            tracker_processor_status=5,
            major_version_number=3,
            minor_version_number=6,
            build_number=1045,
            tracker_serial_number=392_001,
        )
    ]
    script[Command.GET_TRACKER_INFO] = lambda _: [
        answer(Command.GET_TRACKER_INFO, tracker_type=70, tracker_name="AT401")
    ]
    script[Command.GET_CURRENT_PRISM_POSITION] = lambda _: [
        answer(Command.GET_CURRENT_PRISM_POSITION, val1=1.0, val2=2.0, val3=3.0)
    ]
    script[Command.GET_REFLECTORS] = lambda _: [reflector(7, "RRR 0.5in")]
    script[Command.GET_FACE] = lambda _: [answer(Command.GET_FACE, tracker_face=1)]
    script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(val1=1.0, val2=2.0, val3=3.0, std1=0.001, std2=0.002, std3=0.003, std_total=0.004),
    ]
    return script


class FakeTracker:
    """Answers each request from a script and records what it was asked."""

    def __init__(self, script: Script | None = None, *, hello: tuple[object, ...] = ()) -> None:
        self.script = script or healthy()
        self.hello = hello
        self.requests: list[Request] = []
        self.kept: dict[int, Record] = {Command.GET_REFLECTOR: Record(internal_reflector_id=7)}

    def answers(self, request: Request) -> list[object]:
        name = Command(request.command).name
        if name.startswith("SET_") and f"GET_{name[4:]}" in Command.__members__:
            self.kept[Command[f"GET_{name[4:]}"]] = request.values
        if self.script[request.command] is as_set and request.command in self.kept:
            return [answer(request.command, **self.kept[request.command])]
        return self.script[request.command](request)

    async def serve(self, end: MemoryEnd) -> None:
        reader = FrameReader()
        for packet in self.hello:
            await end.send(encode(packet))
        while data := await end.receive():
            reader.receive_data(data)
            while (frame := reader.next_message()) is not None:
                request = decode_request(frame)
                self.requests.append(request)
                for packet in self.answers(request):
                    if packet is HANG_UP:
                        return
                    await end.send(packet if isinstance(packet, bytes) else encode(packet))

    def asked(self, command: int) -> list[Request]:
        return [request for request in self.requests if request.command == command]


class FixedClock:
    async def now_s(self) -> float:
        return 12.5

    async def sleep(self, duration_s: float) -> None:
        raise AssertionError("a tracker driver never sleeps")


def tracker_on(fake: FakeTracker, **options) -> LaserTracker:
    options.setdefault("time_outs", SILENT)
    chunk_bytes = options.pop("chunk_bytes", 65_536)
    return LaserTracker(MemoryLink(fake.serve, chunk_bytes=chunk_bytes), FixedClock(), **options)


async def ready_tracker(fake: FakeTracker, **options) -> LaserTracker:
    tracker = tracker_on(fake, **options)
    await tracker.connect()
    await tracker.initialise()
    return tracker


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


FOREIGN = {
    "units": (Command.GET_UNITS, {"len_unit_type": 5}),
    "temperature": (Command.GET_UNITS, {"len_unit_type": 1, "temp_unit_type": 1}),
    "coordinates": (Command.GET_COORDINATE_SYSTEM_TYPE, {"coord_sys_type": 7}),
    "transformation": (Command.GET_SYSTEM_SETTINGS, {"apply_transformation_params": True}),
    "station": (Command.GET_SYSTEM_SETTINGS, {"apply_station_orientation_params": True}),
    "weather": (Command.GET_SYSTEM_SETTINGS, {"weather_monitor_status": 0}),
}
ANNOUNCED = {
    **FOREIGN,
    "mode": (Command.GET_MEASUREMENT_MODE, {"meas_mode": 1}),
    "reflector": (Command.GET_REFLECTOR, {"internal_reflector_id": 3}),
}


@pytest.mark.parametrize("what", FOREIGN)
async def test_what_another_program_changes_silently_is_found_before_a_point_is_believed(what):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    await tracker.measure_point(duration_s=1.0)
    getter, values = FOREIGN[what]
    fake.kept[getter] = Record(fake.kept[getter] | values)

    for use in (tracker.measure_point(duration_s=1.0), tracker.measure_point(duration_s=1.0)):
        with pytest.raises(NotInitialisedError, match="initialise"):
            await use

    await tracker.initialise()  # sets it again
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("what", ANNOUNCED)
async def test_what_another_program_changes_is_read_back_before_the_next_aim(what):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    getter, values = ANNOUNCED[what]
    fake.kept[getter] = Record(fake.kept[getter] | values)
    said = encode(StatusChange(SystemStatusChange.UNITS_CHANGED))
    fake.script[Command.SET_STATIONARY_MODE_PARAMS] = lambda request: [answer(request.command), said]
    with pytest.raises(NotInitialisedError, match="another program changed"):
        await tracker.measure_point(duration_s=2.0)
    aims = len(fake.asked(Command.GO_POSITION))

    with pytest.raises(NotInitialisedError):
        await tracker.find_reflector((300.0, 0.0, 400.0), search_radius_mm=10.0)

    assert len(fake.asked(Command.GO_POSITION)) == aims


async def test_a_point_during_which_somebody_changed_the_tracker_is_measured_again():
    fake = FakeTracker()
    changing = [True, False]

    def measured(_):
        announced = [StatusChange(SystemStatusChange.UNITS_CHANGED)] * 2 if changing.pop(0) else []
        in_inches = 25.4 if announced else 1.0  # changed, and changed back
        return [
            answer(Command.START_MEASUREMENT),
            *announced,
            single(val1=1.0 / in_inches, val2=2.0 / in_inches, val3=3.0 / in_inches),
        ]

    fake.script[Command.START_MEASUREMENT] = measured
    tracker = await ready_tracker(fake)

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_a_tracker_that_somebody_changes_all_the_time_is_busy():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        StatusChange(SystemStatusChange.TRANSFORMATION_PARAMS_CHANGED),
        single(val1=1.0, val2=2.0, val3=3.0),
    ]

    with pytest.raises(BusyError, match="close that program"):
        await tracker.measure_point(duration_s=1.0)


@pytest.mark.parametrize(
    ("getter", "values"),
    [
        (Command.GET_UNITS, {"len_unit_type": 0}),
        (Command.GET_COORDINATE_SYSTEM_TYPE, {"coord_sys_type": 1}),
        (Command.GET_SYSTEM_SETTINGS, {"apply_station_orientation_params": True}),
        (Command.GET_MEASUREMENT_MODE, {"meas_mode": 1}),
    ],
)
async def test_a_setting_that_the_tracker_does_not_take_over_is_told_when_initialising(getter, values):
    fake = FakeTracker()
    fake.script[getter] = lambda request: [answer(request.command, **values)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="did not take over"):
        await tracker.initialise()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_point(duration_s=1.0)


async def test_a_tracker_that_does_not_tell_its_units_is_not_measured_with():
    fake = FakeTracker()
    fake.script[Command.GET_UNITS] = lambda request: [Answer(request.command, ResultStatus.NOT_IMPLEMENTED)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="number without unit"):
        await tracker.initialise()


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


async def test_initialising_sets_units_mode_frame_and_reflector():
    fake = FakeTracker()

    await ready_tracker(fake)

    assert fake.asked(Command.SET_UNITS)[0].values["len_unit_type"] == 1
    assert fake.asked(Command.SET_MEASUREMENT_MODE)[0].values == {"meas_mode": 0}
    assert fake.asked(Command.SET_COORDINATE_SYSTEM_TYPE)[0].values == {"coord_sys_type": 0}
    assert fake.asked(Command.SET_REFLECTOR)[0].values == {"internal_reflector_id": 7}
    assert fake.asked(Command.INITIALIZE) == []  # it was started up already
    settings = fake.asked(Command.SET_SYSTEM_SETTINGS)[0].values
    assert settings["weather_monitor_status"] == 2
    assert not settings["apply_transformation_params"]
    assert not settings["send_reflector_position_data"]


async def test_initialising_keeps_what_the_tracker_says_about_its_equipment():
    fake = FakeTracker()
    fake.script[Command.GET_SYSTEM_SETTINGS] = lambda _: [
        answer(Command.GET_SYSTEM_SETTINGS, has_nivel=True, has_video_camera=True)
    ]

    await ready_tracker(fake)

    settings = fake.asked(Command.SET_SYSTEM_SETTINGS)[0].values
    assert settings["has_nivel"]
    assert settings["has_video_camera"]


async def test_a_server_that_cannot_tell_its_settings_is_set_up_all_the_same():
    fake = FakeTracker()
    fake.script[Command.GET_SYSTEM_SETTINGS] = lambda _: [
        Answer(Command.GET_SYSTEM_SETTINGS, ResultStatus.NOT_IMPLEMENTED)
    ]

    await ready_tracker(fake)

    assert fake.asked(Command.SET_SYSTEM_SETTINGS)[0].values["weather_monitor_status"] == 2


async def test_the_reflector_set_among_several_is_kept():
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTOR] = lambda _: [answer(Command.GET_REFLECTOR, internal_reflector_id=2)]
    fake.script[Command.GET_REFLECTORS] = lambda _: [reflector(1, "A", total=2), reflector(2, "B", total=2)]

    await ready_tracker(fake)

    assert fake.asked(Command.SET_REFLECTOR)[0].values == {"internal_reflector_id": 2}


@pytest.mark.parametrize("total", [-1, 1_001, 2**31 - 1])
async def test_an_absurd_number_of_reflectors_is_a_protocol_error(total):
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTORS] = lambda _: [reflector(1, "A", total=total)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(RemoteProtocolError, match=f"{total} items"):
        await tracker.initialise()


async def test_a_tracker_without_reflectors_says_so():
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTORS] = lambda _: [reflector(0, "", total=0)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(ConfigurationError, match="none at all"):
        await tracker.initialise()


async def test_a_tracker_that_is_not_started_up_is_initialised_first():
    fake = FakeTracker()
    fake.script[Command.GET_SYSTEM_STATUS] = lambda _: [
        answer(
            Command.GET_SYSTEM_STATUS,
            tracker_processor_status=5 if fake.asked(Command.INITIALIZE) else 3,
        )
    ]

    await ready_tracker(fake)

    assert len(fake.asked(Command.INITIALIZE)) == 1


async def test_a_tracker_that_does_not_come_up_is_reported():
    fake = FakeTracker()
    fake.script[Command.GET_SYSTEM_STATUS] = lambda _: [
        answer(Command.GET_SYSTEM_STATUS, tracker_processor_status=3)
    ]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(NotInitialisedError, match="status display"):
        await tracker.initialise()


async def test_a_reflector_is_chosen_by_name():
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTORS] = lambda _: [
        reflector(7, "RRR 1.5in", total=2),
        reflector(8, "RRR 0.5in", total=2),
    ]

    await ready_tracker(fake, reflector="RRR 0.5in")

    assert fake.asked(Command.SET_REFLECTOR)[0].values == {"internal_reflector_id": 8}


async def test_an_unknown_reflector_is_refused_and_the_known_ones_are_named():
    tracker = tracker_on(FakeTracker(), reflector="BRR")
    await tracker.connect()

    with pytest.raises(ConfigurationError, match=r"'BRR'; it has RRR 0\.5in"):
        await tracker.initialise()


async def test_no_reflector_set_among_several_asks_for_a_name():
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTOR] = lambda _: [answer(Command.GET_REFLECTOR, internal_reflector_id=-1)]
    fake.script[Command.GET_REFLECTORS] = lambda _: [reflector(1, "A", total=2), reflector(2, "B", total=2)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(ConfigurationError, match="A, B in option reflector"):
        await tracker.initialise()


async def test_the_identity_is_read_from_status_and_tracker_info():
    tracker = await ready_tracker(FakeTracker())

    identity = await tracker.identify()

    assert (identity.manufacturer, identity.model) == ("Leica Geosystems", "AT401")
    assert (identity.serial, identity.firmware) == ("392001", "3.6.1045")


async def test_an_older_server_is_identified_by_the_command_it_knows():
    fake = FakeTracker()
    fake.script[Command.GET_TRACKER_INFO] = lambda _: [
        Answer(Command.GET_TRACKER_INFO, ResultStatus.NOT_IMPLEMENTED)
    ]
    fake.script[Command.GET_AT4XX_INFO] = lambda _: [answer(Command.GET_AT4XX_INFO, tracker_type=13)]
    tracker = tracker_on(fake)
    await tracker.connect()

    assert (await tracker.identify()).model == "AT901 B"


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
    ("status", "error", "advice"),
    [
        (ResultStatus.SERVER_BUSY, BusyError, "wait"),
        (ResultStatus.SENSOR_NOT_WARMED_UP, BusyError, "warmed up"),
        (ResultStatus.TRACKER_NOT_INITIALIZED, NotInitialisedError, "initialise it first"),
        (ResultStatus.WRONG_PARAMETER_1, DeviceRefusedError, "value of START_MEASUREMENT"),
        (ResultStatus.NOT_IMPLEMENTED, DeviceRefusedError, "does not know"),
        (ResultStatus.SENSOR_NOT_LEVELED, DeviceRefusedError, "level the stand"),
        (ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED, DeviceRefusedError, "another program"),
        (123_456, MeasurementFailedError, r"123456 \(unknown"),
    ],
)
async def test_a_status_becomes_an_error_with_advice(status, error, advice):
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda request: [Answer(request.command, status)]
    tracker = await ready_tracker(fake)

    with pytest.raises(error, match=advice):
        await tracker.measure_point(duration_s=1.0)


@pytest.mark.parametrize("status", list(ResultStatus)[1:])
@pytest.mark.parametrize("purpose", ["set", "find", "measure"])
async def test_every_status_has_a_sentence(status, purpose):
    sentence = str(error_for(Command.GO_POSITION, status, purpose))

    assert "GO_POSITION" in sentence
    assert ":" in sentence or "value of" in sentence


async def test_a_tracker_in_use_by_another_program_says_so():
    fake = FakeTracker(hello=(ErrorReport(0, ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED),))
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="another program is connected"):
        await tracker.identify()


@pytest.mark.parametrize(
    "use",
    [
        lambda tracker: tracker.measure_point(duration_s=1.0),
        lambda tracker: tracker.find_reflector((1.0, 0.0, 0.0), search_radius_mm=1.0),
        lambda tracker: tracker.change_face(),
        lambda tracker: tracker.environment(),
    ],
)
async def test_nothing_is_measured_in_unknown_units_before_initialising(use):
    fake = FakeTracker()
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(NotInitialisedError, match="since it was connected"):
        await use(tracker)

    assert fake.requests == []


async def test_silence_is_reported_and_a_late_answer_is_never_mistaken():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    fake.script[Command.GET_ENVIRONMENT_PARAMS] = lambda _: []

    with pytest.raises(NoReplyError, match="GET_ENVIRONMENT_PARAMS"):
        await tracker.environment()

    assert not tracker.connected


async def test_a_stream_of_positions_does_not_hide_that_the_answer_is_missing():
    async def chatter(end: MemoryEnd) -> None:
        while True:
            await end.send(encode(Result(PacketType.REFLECTOR_POS_RESULT, Record(val1=0, val2=0, val3=0))))
            await asyncio.sleep(0.001)

    tracker = LaserTracker(MemoryLink(chatter), FixedClock(), time_outs=SILENT)
    await tracker.connect()

    async with asyncio.timeout(5.0):
        with pytest.raises(NoReplyError):
            await tracker.identify()


async def test_an_accepted_measurement_without_a_result_is_silence():
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [answer(Command.START_MEASUREMENT)]
    tracker = await ready_tracker(fake)

    with pytest.raises(NoReplyError):
        await tracker.measure_point(duration_s=0.01)


async def test_a_connection_closed_in_the_middle_of_a_packet_is_lost():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    half = encode(single())[:100]
    fake.script[Command.START_MEASUREMENT] = lambda _: [half, HANG_UP]

    with pytest.raises(ConnectionLostError, match="middle of a message"):
        await tracker.measure_point(duration_s=1.0)

    assert not tracker.connected


async def test_it_can_be_connected_again_after_a_loss_and_wants_initialising():
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    fake.script[Command.START_MEASUREMENT] = lambda _: [HANG_UP]
    with pytest.raises(ConnectionLostError):
        await tracker.measure_point(duration_s=1.0)
    with pytest.raises(ConnectionLostError, match="connect first"):
        await tracker.measure_point(duration_s=1.0)
    fake.script = healthy()

    await tracker.connect()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_point(duration_s=1.0)
    await tracker.initialise()

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "garbage",
    [b"HTTP/1.1 400 Bad Request\r\n\r\n", struct.pack("<iII", 12, 99, 0), struct.pack("<iIII", 16, 0, 98, 0)],
)
async def test_garbage_is_a_protocol_error_and_closes_the_link(garbage):
    fake = FakeTracker()
    tracker = await ready_tracker(fake)
    fake.script[Command.GET_FACE] = lambda _: [garbage]

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_point(duration_s=1.0)

    assert not tracker.connected


async def test_a_point_that_is_no_number_is_refused():
    fake = FakeTracker()
    fake.script[Command.START_MEASUREMENT] = lambda _: [
        answer(Command.START_MEASUREMENT),
        single(val1=float("nan")),
    ]
    tracker = await ready_tracker(fake)

    with pytest.raises(RemoteProtocolError, match="no point"):
        await tracker.measure_point(duration_s=1.0)


async def test_an_abandoned_request_closes_the_link():
    fake = FakeTracker()
    tracker = await ready_tracker(fake, time_outs=TimeOuts(command_s=5.0))
    fake.script[Command.START_MEASUREMENT] = lambda _: []
    task = asyncio.create_task(tracker.measure_point(duration_s=1.0))
    while not fake.asked(Command.START_MEASUREMENT):
        await asyncio.sleep(0)

    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task

    assert not tracker.connected


async def test_two_tasks_take_turns():
    fake = FakeTracker()
    fake.script[Command.GET_ENVIRONMENT_PARAMS] = lambda _: [
        answer(Command.GET_ENVIRONMENT_PARAMS, temperature=21.0, pressure=1013.0, humidity=40.0)
    ]
    tracker = await ready_tracker(fake)

    reading, air = await asyncio.gather(tracker.measure_point(duration_s=1.0), tracker.environment())

    assert reading.point_mm == (1.0, 2.0, 3.0)
    assert (air.temperature_c, air.pressure_hpa, air.humidity_percent) == (21.0, 1013.0, 40.0)


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


async def test_nobody_at_the_address_is_a_failed_connection():
    tracker = LaserTracker(MemoryLink(None), FixedClock())

    with pytest.raises(ConnectFailedError, match="nobody answers"):
        await tracker.connect()


async def test_closing_twice_or_before_connecting_is_harmless():
    tracker = tracker_on(FakeTracker())

    await tracker.close()
    await tracker.connect()
    await tracker.close()
    await tracker.close()

    assert not tracker.connected


def test_the_fake_can_answer_every_command():
    assert set(EXCHANGES) <= set(healthy())
