"""What an emScon tracker is set to, and what becomes of it when another program changes that."""

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    FakeTracker,
    answer,
    ready_tracker,
    reflector,
    single,
    tracker_on,
)
from truepose_drivers.errors import (
    BusyError,
    ConfigurationError,
    DeviceRefusedError,
    NotInitialisedError,
    RemoteProtocolError,
)
from truepose_drivers.guard import guarded
from truepose_drivers.leica_emscon.protocol import (
    Answer,
    Command,
    Record,
    ResultStatus,
    StatusChange,
    SystemStatusChange,
    encode,
)

pytestmark = pytest.mark.simulated_time

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

    assert {request.command for request in fake.requests} == {Command.GET_SYSTEM_STATUS}


async def test_the_reflector_is_stated_as_the_tracker_confirmed_it():
    fake = FakeTracker()
    stored = {"target_type": 6, "surface_offset": 6.35}
    fake.script[Command.GET_REFLECTORS] = lambda _: [reflector(7, "RRR 0.5in", **stored)]
    tracker = tracker_on(fake)
    await tracker.connect()
    assert tracker.settings == ""

    await tracker.initialise()

    stated = "The tracker measures the reflector RRR 0.5in (RRR05, surface offset 6.350 mm)."
    assert guarded("leica_emscon", "tracker", tracker).settings == stated


async def test_a_reflector_that_the_tracker_does_not_take_over_is_told_and_none_is_stated():
    fake = FakeTracker()
    fake.script[Command.GET_REFLECTOR] = lambda request: [answer(request.command, internal_reflector_id=3)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="reflector"):
        await tracker.initialise()
    assert tracker.settings == ""
