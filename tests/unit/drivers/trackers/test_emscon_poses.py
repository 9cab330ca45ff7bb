"""An emScon tracker's poses of a probe, against a scripted server that lives in memory."""

import math

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    SILENT,
    FakeTracker,
    answer,
    answered,
    healthy,
    refused,
    single,
    told,
)
from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.api import PoseTracker
from truepose_drivers.errors import (
    ArtefactNotSeenError,
    DeviceRefusedError,
    NotInitialisedError,
    OutOfVolumeError,
    RemoteProtocolError,
)
from truepose_drivers.guard import guarded
from truepose_drivers.leica_emscon.probe import ProbeTracker
from truepose_drivers.leica_emscon.protocol import (
    Answer,
    Command,
    ErrorReport,
    PacketType,
    Result,
    ResultStatus,
    RotationStatus,
    StatusChange,
    SystemStatusChange,
    encode,
)

pytestmark = pytest.mark.simulated_time

POSE = {
    "meas_mode": 6,
    "rotation_status": RotationStatus.VALID,
    "internal_probe_id": 2,
    "position1": 1500.0,
    "position2": -200.0,
    "position3": 300.0,
    "std_dev_position1": 0.001,
    "std_dev_position2": 0.002,
    "std_dev_position3": 0.003,
    "std_dev_rotation_angle_total": 5e-5,
    "quaternion0": 0.5,
    "quaternion1": -0.5,
    "quaternion2": 0.5,
    "quaternion3": 0.5,
}


def pose(status: int = 0, **changes) -> Result:
    return single(PacketType.STATIONARY_PROBE_MEAS_RESULT, status, **(POSE | changes))


@pytest.fixture
def emscon() -> FakeTracker:
    """A tracker that sees probe 2, a T-Mac, of the two that it knows."""
    script = healthy()
    script[Command.GET_PROBE] = told(internal_probe_id=2)
    script[Command.GET_PROBES] = lambda request: [
        answer(
            request.command,
            total_probes=2,
            internal_probe_id=number,
            serial_number=4700 + number,
            probe_type=kind,
            name=name,
        )
        for number, kind, name in ((1, 2, "T-Probe"), (2, 5, "T-Mac"))
    ]
    script[Command.START_MEASUREMENT] = answered(pose())
    return FakeTracker(script)


def tracker_on(fake: FakeTracker, **options) -> ProbeTracker:
    return ProbeTracker(MemoryLink(fake.serve), FixedClock(), time_outs=SILENT, **options)


@pytest.fixture
async def tracker(emscon) -> ProbeTracker:
    return await ready(emscon)


async def ready(fake: FakeTracker, **options) -> ProbeTracker:
    tracker = tracker_on(fake, **options)
    await tracker.connect()
    await tracker.initialise()
    return tracker


async def test_a_pose_is_what_the_tracker_said(tracker):
    as_api: PoseTracker = guarded("leica_emscon_6d", "pose_tracker", tracker)

    reading = await as_api.measure_pose(duration_s=2.0)

    assert reading.quaternion == (0.5, -0.5, 0.5, 0.5)
    assert reading.position_mm == (1500.0, -200.0, 300.0)
    assert reading.position_deviation_mm == (0.001, 0.002, 0.003)
    assert reading.rotation_deviation_rad == 5e-5
    assert math.isnan(reading.rms_mm)  # emScon states none
    assert (reading.frames, reading.duration_s, reading.time_s) == (1, 2.0, 12.5)


async def test_a_rounded_quaternion_is_made_a_unit_one(emscon, tracker):
    emscon.script[Command.START_MEASUREMENT] = answered(pose(quaternion0=0.50001))

    reading = await tracker.measure_pose(duration_s=2.0)

    assert math.hypot(*reading.quaternion) == pytest.approx(1.0, abs=1e-12)


async def test_initialising_asks_for_poses_in_the_house_units_and_for_the_beam_to_be_caught_again(
    emscon, tracker
):
    assert emscon.asked(Command.SET_MEASUREMENT_MODE)[0].values == {"meas_mode": 6}
    assert emscon.asked(Command.SET_UNITS)[0].values["len_unit_type"] == 1
    assert emscon.asked(Command.SET_LONG_SYSTEM_PARAMETER)[0].values == {"system_param": 411, "parameter": 1}
    assert emscon.asked(Command.SET_REFLECTOR) == []
    stated = "The tracker measures the probe T-Mac (machine control probe multi side, serial 4702)."
    assert tracker.settings == stated


@pytest.mark.parametrize(
    ("command", "says", "advice"),
    [
        (Command.SET_MEASUREMENT_MODE, refused(), "driver leica_emscon"),
        (Command.GET_PROBE, told(internal_probe_id=-1), "guide the beam"),
        (Command.GET_PROBE, told(internal_probe_id=9), "guide the beam"),
    ],
)
async def test_a_tracker_without_poses_or_a_probe_that_it_knows_says_so(emscon, command, says, advice):
    emscon.script[command] = says
    tracker = tracker_on(emscon)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match=advice):
        await tracker.initialise()


async def test_another_probe_than_the_cell_names_is_refused(emscon):
    tracker = tracker_on(emscon, probe="T-Probe")
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="'T-Mac', option probe names 'T-Probe'"):
        await tracker.initialise()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize(
    ("status", "error", "advice"),
    [
        (RotationStatus.ERROR | RotationStatus.NOT_ENOUGH_LEDS, ArtefactNotSeenError, "LEDs"),
        (RotationStatus.VALID | RotationStatus.RMS_TOO_HIGH, ArtefactNotSeenError, "compensation"),
        (RotationStatus.ERROR | RotationStatus.ANGLE_OUT_OF_RANGE, OutOfVolumeError, "points too far away"),
        (RotationStatus.ERROR | RotationStatus.DISTANCE_OUT_OF_RANGE, OutOfVolumeError, "too close"),
        (RotationStatus.ERROR, ArtefactNotSeenError, "unreliable"),
        (RotationStatus.VALID | RotationStatus.ERROR, ArtefactNotSeenError, "unreliable"),
        (0, ArtefactNotSeenError, "unreliable"),
    ],
)
async def test_an_orientation_that_the_tracker_does_not_vouch_for_is_no_pose(
    emscon, tracker, status, error, advice
):
    emscon.script[Command.START_MEASUREMENT] = answered(pose(rotation_status=status))

    with pytest.raises(error, match=advice):
        await tracker.measure_pose(duration_s=1.0)
    assert tracker.connected

    emscon.script[Command.START_MEASUREMENT] = answered(pose())
    assert (await tracker.measure_pose(duration_s=1.0)).position_mm == (1500.0, -200.0, 300.0)


@pytest.mark.parametrize(
    "changes",
    [
        {"rotation_status": RotationStatus.VALID | RotationStatus.FROZEN},
        {"quaternion0": 0.6},
        {"quaternion1": math.nan},
        {"position2": math.inf},
        {"std_dev_position3": math.inf},
        {"std_dev_rotation_angle_total": -1.0},
        {"meas_mode": 0},
        {"is_try_mode": True},
    ],
)
async def test_what_is_no_pose_closes_the_link(emscon, tracker, changes):
    emscon.script[Command.START_MEASUREMENT] = answered(pose(**changes))

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_pose(duration_s=1.0)
    assert not tracker.connected


@pytest.mark.parametrize(
    ("says", "error", "complaint"),
    [
        (answered(pose(tip_status=1)), DeviceRefusedError, "tip"),
        (refused(ResultStatus.MEASUREMENT_FACE2_NOT_ALLOWED_6D), DeviceRefusedError, "change the face"),
        (answered(pose(internal_probe_id=1)), NotInitialisedError, "another probe"),
        (
            answered(encode(pose()) + encode(pose(position1=1.0))),
            RemoteProtocolError,
            "more data than requested",
        ),
    ],
)
async def test_a_measurement_that_is_refused_or_of_something_else_is_told(
    emscon, tracker, says, error, complaint
):
    emscon.script[Command.START_MEASUREMENT] = says

    with pytest.raises(error, match=complaint):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize(
    "says",
    [
        answered(single(PacketType.SINGLE_MEAS_RESULT_2, val1=1.0), pose()),  # a point is no pose
        lambda request: [pose(position1=777.0), answer(request.command), pose()],  # under way before
    ],
)
async def test_a_pose_is_found_among_whatever_else_comes(emscon, tracker, says):
    emscon.script[Command.START_MEASUREMENT] = says

    assert (await tracker.measure_pose(duration_s=1.0)).position_mm == (1500.0, -200.0, 300.0)


@pytest.mark.parametrize("changed", [{"internal_probe_id": 1}, {"internal_tip_adapter_id": 3}])
async def test_another_probe_or_tip_than_before_is_another_frame(emscon, tracker, changed):
    await tracker.measure_pose(duration_s=1.0)
    emscon.script[Command.START_MEASUREMENT] = answered(pose(**changed))

    for _ in range(2):
        with pytest.raises(NotInitialisedError, match="initialise"):
            await tracker.measure_pose(duration_s=1.0)

    present = {"internal_probe_id": changed.get("internal_probe_id", 2)}
    emscon.script[Command.GET_PROBE] = told(**present)
    await tracker.initialise()
    assert (await tracker.measure_pose(duration_s=1.0)).frames == 1


ANNOUNCED = {
    SystemStatusChange.UNITS_CHANGED: (Command.GET_UNITS, {"len_unit_type": 5}),
    SystemStatusChange.MEASUREMENT_MODE_CHANGED: (Command.GET_MEASUREMENT_MODE, {"meas_mode": 0}),
    SystemStatusChange.PROBE_CHANGED: (Command.GET_PROBE, {"internal_probe_id": 1}),
    SystemStatusChange.PROBE_COMPENSATION_CHANGED: (
        Command.GET_PROBE_COMPENSATION,
        {"internal_probe_compensation_id": 5},
    ),
    SystemStatusChange.TCAM_TO_TRACKER_COMPENSATION_CHANGED: (
        Command.GET_T_CAM_TO_TRACKER_COMPENSATION,
        {"internal_t_cam_to_tracker_compensation_id": 5},
    ),
}


@pytest.mark.parametrize("event", ANNOUNCED)
async def test_what_another_program_changes_is_found_before_a_pose_is_believed(emscon, tracker, event):
    getter, values = ANNOUNCED[event]

    def change(request):
        found = emscon.kept.get(getter) or answer(getter).values
        emscon.script[getter] = told(**(found | values))
        emscon.kept.pop(getter, None)
        return [answer(request.command), StatusChange(event), pose()]

    emscon.script[Command.START_MEASUREMENT] = change

    with pytest.raises(NotInitialisedError, match="another program changed"):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize(
    "packets",
    [
        [Answer(Command.START_MEASUREMENT, ResultStatus.NO_DISTANCE_SET)],
        [answer(Command.START_MEASUREMENT), ErrorReport(49, ResultStatus.NO_ACTIVE_MEASUREMENTPROBE)],
        [answer(Command.START_MEASUREMENT), pose(ResultStatus.BAD_6D_RESULT)],
    ],
)
async def test_a_probe_that_is_hidden_is_reported_however_the_tracker_says_it(emscon, tracker, packets):
    emscon.script[Command.START_MEASUREMENT] = lambda _: packets

    with pytest.raises(ArtefactNotSeenError, match="line of sight"):
        await tracker.measure_pose(duration_s=1.0)
    assert tracker.connected


async def test_a_pose_of_an_earlier_measurement_is_not_taken_again(emscon, tracker):
    assert (await tracker.measure_pose(duration_s=1.0)).position_mm[0] == 1500.0
    assert (await tracker.measure_pose(duration_s=1.0)).position_mm[0] == 1500.0  # the prism stands there
    emscon.script[Command.GET_CURRENT_PRISM_POSITION] = told(val1=900.0)

    with pytest.raises(RemoteProtocolError, match="earlier measurement again"):
        await tracker.measure_pose(duration_s=1.0)
    assert not tracker.connected


@pytest.mark.parametrize("member", ["power lock", "compensations"])
async def test_a_tracker_that_lacks_what_is_not_needed_is_initialised_all_the_same(emscon, member):
    lacking = {
        "power lock": [Command.SET_LONG_SYSTEM_PARAMETER],
        "compensations": [Command.GET_PROBE_COMPENSATION, Command.GET_T_CAM_TO_TRACKER_COMPENSATION],
    }[member]
    for command in lacking:
        emscon.script[command] = refused()

    tracker = await ready(emscon)

    assert (await tracker.measure_pose(duration_s=1.0)).frames == 1
