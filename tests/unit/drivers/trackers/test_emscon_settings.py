"""What an emScon tracker is set to, and what becomes of it when another program changes that."""

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    answer,
    answered,
    point,
    ready_tracker,
    reflector,
    refused,
    told,
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
from truepose_drivers.leica_emscon.protocol import Command, Record, StatusChange, SystemStatusChange, encode

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


def reflectors(*named: tuple[int, str]):
    """Answer with a list of reflectors."""
    return lambda _: [reflector(number, name, total=len(named)) for number, name in named]


@pytest.mark.parametrize("what", FOREIGN)
async def test_what_another_program_changes_silently_is_found_before_a_point_is_believed(
    emscon, tracker, what
):
    await tracker.measure_point(duration_s=1.0)
    getter, values = FOREIGN[what]
    emscon.kept[getter] = Record(emscon.kept[getter] | values)

    for _ in range(2):
        with pytest.raises(NotInitialisedError, match="initialise"):
            await tracker.measure_point(duration_s=1.0)

    await tracker.initialise()  # sets it again
    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("what", ANNOUNCED)
async def test_what_another_program_changes_is_read_back_before_the_next_aim(emscon, tracker, what):
    getter, values = ANNOUNCED[what]
    emscon.kept[getter] = Record(emscon.kept[getter] | values)
    said = encode(StatusChange(SystemStatusChange.UNITS_CHANGED))
    emscon.script[Command.SET_STATIONARY_MODE_PARAMS] = answered(said)
    with pytest.raises(NotInitialisedError, match="another program changed"):
        await tracker.measure_point(duration_s=2.0)
    aims = len(emscon.asked(Command.GO_POSITION))

    with pytest.raises(NotInitialisedError):
        await tracker.find_reflector((300.0, 0.0, 400.0), search_radius_mm=10.0)

    assert len(emscon.asked(Command.GO_POSITION)) == aims


async def test_a_point_during_which_somebody_changed_the_tracker_is_measured_again(emscon, tracker):
    changed = [StatusChange(SystemStatusChange.UNITS_CHANGED)] * 2  # and changed back
    in_inches = point(val1=1.0 / 25.4, val2=2.0 / 25.4, val3=3.0 / 25.4)
    results = iter([answered(*changed, in_inches), answered(point())])
    emscon.script[Command.START_MEASUREMENT] = lambda request: next(results)(request)

    assert (await tracker.measure_point(duration_s=1.0)).point_mm == (1.0, 2.0, 3.0)


async def test_a_tracker_that_somebody_changes_all_the_time_is_busy(emscon, tracker):
    change = StatusChange(SystemStatusChange.TRANSFORMATION_PARAMS_CHANGED)
    emscon.script[Command.START_MEASUREMENT] = answered(change, point())

    with pytest.raises(BusyError, match="close that program"):
        await tracker.measure_point(duration_s=1.0)


NOT_INITIALISED = [
    (Command.GET_UNITS, told(len_unit_type=0), DeviceRefusedError, "did not accept"),
    (Command.GET_COORDINATE_SYSTEM_TYPE, told(coord_sys_type=1), DeviceRefusedError, "did not accept"),
    (
        Command.GET_SYSTEM_SETTINGS,
        told(apply_station_orientation_params=True),
        DeviceRefusedError,
        "did not accept",
    ),
    (Command.GET_MEASUREMENT_MODE, told(meas_mode=1), DeviceRefusedError, "did not accept"),
    (Command.GET_REFLECTOR, told(internal_reflector_id=3), DeviceRefusedError, "reflector"),
    (Command.GET_UNITS, refused(), DeviceRefusedError, "without a unit"),
    (Command.GET_SYSTEM_STATUS, told(tracker_processor_status=3), NotInitialisedError, "status display"),
    (Command.GET_REFLECTORS, lambda _: [reflector(0, "", total=0)], ConfigurationError, "none at all"),
    *(
        (
            Command.GET_REFLECTORS,
            lambda _, total=total: [reflector(1, "A", total=total)],
            RemoteProtocolError,
            f"{total} items",
        )
        for total in (-1, 1_001, 2**31 - 1)
    ),
]


@pytest.mark.parametrize(("command", "says", "error", "complaint"), NOT_INITIALISED)
async def test_a_tracker_that_cannot_be_set_up_says_why_and_measures_nothing(
    emscon, command, says, error, complaint
):
    emscon.script[command] = says
    tracker = tracker_on(emscon)
    await tracker.connect()

    with pytest.raises(error, match=complaint):
        await tracker.initialise()
    assert tracker.settings == ""
    with pytest.raises(NotInitialisedError):
        await tracker.measure_point(duration_s=1.0)


async def test_initialising_sets_units_mode_frame_and_reflector(emscon, tracker):
    assert emscon.asked(Command.SET_UNITS)[0].values["len_unit_type"] == 1
    assert emscon.asked(Command.SET_MEASUREMENT_MODE)[0].values == {"meas_mode": 0}
    assert emscon.asked(Command.SET_COORDINATE_SYSTEM_TYPE)[0].values == {"coord_sys_type": 0}
    assert emscon.asked(Command.SET_REFLECTOR)[0].values == {"internal_reflector_id": 7}
    assert emscon.asked(Command.INITIALIZE) == []  # it was started up already
    settings = emscon.asked(Command.SET_SYSTEM_SETTINGS)[0].values
    assert settings["weather_monitor_status"] == 2
    assert not settings["apply_transformation_params"]
    assert not settings["send_reflector_position_data"]


@pytest.mark.parametrize(
    ("says", "has"), [(told(has_nivel=True, has_video_camera=True), True), (refused(), False)]
)
async def test_initialising_keeps_what_the_tracker_says_about_its_equipment_if_it_does(emscon, says, has):
    emscon.script[Command.GET_SYSTEM_SETTINGS] = says

    await ready_tracker(emscon)

    settings = emscon.asked(Command.SET_SYSTEM_SETTINGS)[0].values
    assert settings["weather_monitor_status"] == 2
    assert (settings["has_nivel"], settings["has_video_camera"]) == (has, has)


async def test_a_tracker_that_is_not_started_up_is_initialised_first(emscon):
    emscon.script[Command.GET_SYSTEM_STATUS] = lambda request: [
        answer(request.command, tracker_processor_status=5 if emscon.asked(Command.INITIALIZE) else 3)
    ]

    await ready_tracker(emscon)

    assert len(emscon.asked(Command.INITIALIZE)) == 1


@pytest.mark.parametrize(
    ("present", "named", "chosen"), [(2, None, 2), (1, "RRR 0.5in", 2), (2, "RRR 1.5in", 1)]
)
async def test_a_reflector_is_chosen_by_name_or_the_one_set_is_kept(emscon, present, named, chosen):
    emscon.kept[Command.GET_REFLECTOR] = Record(internal_reflector_id=present)
    emscon.script[Command.GET_REFLECTORS] = reflectors((1, "RRR 1.5in"), (2, "RRR 0.5in"))

    await ready_tracker(emscon, reflector=named)

    assert emscon.asked(Command.SET_REFLECTOR)[0].values == {"internal_reflector_id": chosen}


@pytest.mark.parametrize(
    ("named", "complaint"),
    [("BRR", r"'BRR'; it has RRR 0\.5in, RRR 1\.5in"), (None, r"RRR 0\.5in, RRR 1\.5in in option reflector")],
)
async def test_a_reflector_that_is_not_known_or_not_set_is_asked_for_by_name(emscon, named, complaint):
    emscon.kept[Command.GET_REFLECTOR] = Record(internal_reflector_id=-1)
    emscon.script[Command.GET_REFLECTORS] = reflectors((1, "RRR 1.5in"), (2, "RRR 0.5in"))
    tracker = tracker_on(emscon, reflector=named)
    await tracker.connect()

    with pytest.raises(ConfigurationError, match=complaint):
        await tracker.initialise()


async def test_the_identity_is_read_from_status_and_tracker_info(tracker):
    identity = await tracker.identify()

    assert (identity.manufacturer, identity.model) == ("Leica Geosystems", "AT401")
    assert (identity.serial, identity.firmware) == ("392001", "3.6.1045")


async def test_an_older_server_is_identified_by_the_command_it_knows(emscon, tracker):
    emscon.script[Command.GET_TRACKER_INFO] = refused()
    emscon.script[Command.GET_AT4XX_INFO] = told(tracker_type=13)

    assert (await tracker.identify()).model == "AT901 B"


@pytest.mark.parametrize(
    ("use", "numbers"),
    [
        ("measure_point", {"duration_s": 1.0}),
        ("find_reflector", {"near_mm": (1.0, 0.0, 0.0), "search_radius_mm": 1.0}),
        ("change_face", {}),
        ("environment", {}),
    ],
)
async def test_nothing_is_measured_in_unknown_units_before_initialising(emscon, use, numbers):
    tracker = tracker_on(emscon)
    await tracker.connect()

    with pytest.raises(NotInitialisedError, match="since it was connected"):
        await getattr(tracker, use)(**numbers)

    assert {request.command for request in emscon.requests} == {Command.GET_SYSTEM_STATUS}


async def test_the_reflector_is_stated_as_the_tracker_confirmed_it(emscon):
    stored = {"target_type": 6, "surface_offset": 6.35}
    emscon.script[Command.GET_REFLECTORS] = lambda _: [reflector(7, "RRR 0.5in", **stored)]

    tracker = await ready_tracker(emscon)

    stated = "The tracker measures the reflector RRR 0.5in (RRR05, surface offset 6.350 mm)."
    assert guarded("leica_emscon", "tracker", tracker).settings == stated
