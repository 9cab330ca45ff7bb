"""An emScon tracker's poses of a probe, against a scripted server that lives in memory."""

import math

import pytest

from tests.helpers.instruments.emscon_in_memory import (
    SILENT,
    FakeTracker,
    answer,
    healthy,
    single,
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


def measured(*packets):
    return lambda request: [answer(request.command), *packets]


def with_probe() -> FakeTracker:
    """A tracker that sees probe 2, a T-Mac, of the two that it knows."""
    script = healthy()
    script[Command.GET_PROBE] = lambda request: [answer(request.command, internal_probe_id=2)]
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
    script[Command.START_MEASUREMENT] = measured(pose())
    return FakeTracker(script)


def tracker_on(fake: FakeTracker, **options) -> ProbeTracker:
    return ProbeTracker(MemoryLink(fake.serve), FixedClock(), time_outs=SILENT, **options)


async def ready(fake: FakeTracker, **options) -> ProbeTracker:
    tracker = tracker_on(fake, **options)
    await tracker.connect()
    await tracker.initialise()
    return tracker


async def test_a_pose_is_what_the_tracker_said():
    tracker: PoseTracker = guarded("leica_emscon_6d", "pose_tracker", await ready(with_probe()))

    reading = await tracker.measure_pose(duration_s=2.0)

    assert reading.quaternion == (0.5, -0.5, 0.5, 0.5)
    assert reading.position_mm == (1500.0, -200.0, 300.0)
    assert reading.position_deviation_mm == (0.001, 0.002, 0.003)
    assert reading.rotation_deviation_rad == 5e-5
    assert math.isnan(reading.rms_mm)  # emScon states none
    assert (reading.frames, reading.duration_s, reading.time_s) == (1, 2.0, 12.5)


async def test_a_rounded_quaternion_is_made_a_unit_one():
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = measured(pose(quaternion0=0.50001))
    tracker = await ready(fake)

    reading = await tracker.measure_pose(duration_s=2.0)

    assert math.hypot(*reading.quaternion) == pytest.approx(1.0, abs=1e-12)


async def test_initialising_asks_for_poses_in_the_house_units_and_for_the_beam_to_be_caught_again():
    fake = with_probe()

    tracker = await ready(fake)

    assert fake.asked(Command.SET_MEASUREMENT_MODE)[0].values == {"meas_mode": 6}
    assert fake.asked(Command.SET_UNITS)[0].values["len_unit_type"] == 1
    assert fake.asked(Command.SET_LONG_SYSTEM_PARAMETER)[0].values == {"system_param": 411, "parameter": 1}
    assert fake.asked(Command.SET_REFLECTOR) == []
    stated = "The tracker measures the probe T-Mac (machine control probe multi side, serial 4702)."
    assert tracker.settings == stated


async def test_a_tracker_without_poses_says_which_driver_it_needs():
    fake = with_probe()
    fake.script[Command.SET_MEASUREMENT_MODE] = lambda request: [
        Answer(request.command, ResultStatus.NOT_IMPLEMENTED)
    ]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="driver leica_emscon"):
        await tracker.initialise()


@pytest.mark.parametrize("says", [{"internal_probe_id": -1}, {"internal_probe_id": 9}])
async def test_no_probe_that_the_tracker_knows_is_told(says):
    fake = with_probe()
    fake.script[Command.GET_PROBE] = lambda request: [answer(request.command, **says)]
    tracker = tracker_on(fake)
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="lead the beam"):
        await tracker.initialise()


async def test_another_probe_than_the_cell_names_is_refused():
    tracker = tracker_on(with_probe(), probe="T-Probe")
    await tracker.connect()

    with pytest.raises(DeviceRefusedError, match="'T-Mac', option probe names 'T-Probe'"):
        await tracker.initialise()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize(
    ("status", "error", "advice"),
    [
        (RotationStatus.ERROR | RotationStatus.NOT_ENOUGH_LEDS, ArtefactNotSeenError, "lamps"),
        (RotationStatus.VALID | RotationStatus.RMS_TOO_HIGH, ArtefactNotSeenError, "compensation"),
        (RotationStatus.ERROR | RotationStatus.ANGLE_OUT_OF_RANGE, OutOfVolumeError, "turned"),
        (RotationStatus.ERROR | RotationStatus.DISTANCE_OUT_OF_RANGE, OutOfVolumeError, "near"),
        (RotationStatus.ERROR, ArtefactNotSeenError, "vouch"),
        (RotationStatus.VALID | RotationStatus.ERROR, ArtefactNotSeenError, "vouch"),
        (0, ArtefactNotSeenError, "vouch"),
    ],
)
async def test_an_orientation_that_the_tracker_does_not_vouch_for_is_no_pose(status, error, advice):
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = measured(pose(rotation_status=status))
    tracker = await ready(fake)

    with pytest.raises(error, match=advice):
        await tracker.measure_pose(duration_s=1.0)
    assert tracker.connected

    fake.script[Command.START_MEASUREMENT] = measured(pose())
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
async def test_what_is_no_pose_closes_the_link(changes):
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = measured(pose(**changes))
    tracker = await ready(fake)

    with pytest.raises(RemoteProtocolError):
        await tracker.measure_pose(duration_s=1.0)
    assert not tracker.connected


async def test_a_tip_that_the_tracker_does_not_know_is_refused():
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = measured(pose(tip_status=1))
    tracker = await ready(fake)

    with pytest.raises(DeviceRefusedError, match="tip"):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize("changed", [{"internal_probe_id": 1}, {"internal_tip_adapter_id": 3}])
async def test_another_probe_or_tip_than_before_is_another_frame(changed):
    fake = with_probe()
    tracker = await ready(fake)
    await tracker.measure_pose(duration_s=1.0)
    fake.script[Command.START_MEASUREMENT] = measured(pose(**changed))

    for _ in range(2):
        with pytest.raises(NotInitialisedError, match="initialise"):
            await tracker.measure_pose(duration_s=1.0)

    present = {"internal_probe_id": changed.get("internal_probe_id", 2)}
    fake.script[Command.GET_PROBE] = lambda request: [answer(request.command, **present)]
    await tracker.initialise()
    assert (await tracker.measure_pose(duration_s=1.0)).frames == 1


async def test_another_probe_than_the_one_that_was_told_is_refused_at_once():
    fake = with_probe()
    tracker = await ready(fake)
    fake.script[Command.START_MEASUREMENT] = measured(pose(internal_probe_id=1))

    with pytest.raises(NotInitialisedError, match="another probe"):
        await tracker.measure_pose(duration_s=1.0)


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
async def test_what_another_program_changes_is_found_before_a_pose_is_believed(event):
    fake = with_probe()
    tracker = await ready(fake)
    getter, values = ANNOUNCED[event]

    def change(request):
        found = fake.kept.get(getter) or answer(getter).values
        fake.script[getter] = lambda asked: [answer(asked.command, **(found | values))]
        fake.kept.pop(getter, None)
        return [answer(request.command), StatusChange(event), pose()]

    fake.script[Command.START_MEASUREMENT] = change

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
async def test_a_probe_that_is_hidden_is_reported_however_the_tracker_says_it(packets):
    fake = with_probe()
    tracker = await ready(fake)
    fake.script[Command.START_MEASUREMENT] = lambda _: packets

    with pytest.raises(ArtefactNotSeenError, match="line of sight"):
        await tracker.measure_pose(duration_s=1.0)
    assert tracker.connected


async def test_a_tracker_that_stands_in_face_two_says_what_to_do():
    fake = with_probe()
    tracker = await ready(fake)
    refused = ResultStatus.MEASUREMENT_FACE2_NOT_ALLOWED_6D
    fake.script[Command.START_MEASUREMENT] = lambda request: [Answer(request.command, refused)]

    with pytest.raises(DeviceRefusedError, match="change the face"):
        await tracker.measure_pose(duration_s=1.0)


async def test_a_pose_of_an_earlier_measurement_is_not_taken_again():
    fake = with_probe()
    tracker = await ready(fake)
    assert (await tracker.measure_pose(duration_s=1.0)).position_mm[0] == 1500.0
    assert (await tracker.measure_pose(duration_s=1.0)).position_mm[0] == 1500.0  # the prism stands there
    fake.script[Command.GET_CURRENT_PRISM_POSITION] = lambda request: [answer(request.command, val1=900.0)]

    with pytest.raises(RemoteProtocolError, match="earlier measurement again"):
        await tracker.measure_pose(duration_s=1.0)
    assert not tracker.connected


async def test_a_point_is_no_pose():
    fake = with_probe()
    point = single(PacketType.SINGLE_MEAS_RESULT_2, val1=1.0)
    fake.script[Command.START_MEASUREMENT] = measured(point, pose())
    tracker = await ready(fake)

    assert (await tracker.measure_pose(duration_s=1.0)).position_mm == (1500.0, -200.0, 300.0)


async def test_a_pose_that_was_under_way_before_the_question_is_passed_over():
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = lambda request: [
        pose(position1=777.0),
        answer(request.command),
        pose(),
    ]
    tracker = await ready(fake)

    assert (await tracker.measure_pose(duration_s=1.0)).position_mm[0] == 1500.0


async def test_two_poses_to_one_question_close_the_link():
    fake = with_probe()
    fake.script[Command.START_MEASUREMENT] = measured(encode(pose()) + encode(pose(position1=1.0)))
    tracker = await ready(fake)

    with pytest.raises(RemoteProtocolError, match="more than was asked"):
        await tracker.measure_pose(duration_s=1.0)


@pytest.mark.parametrize("member", ["power lock", "compensations"])
async def test_a_tracker_that_lacks_what_is_not_needed_is_initialised_all_the_same(member):
    fake = with_probe()
    lacking = {
        "power lock": [Command.SET_LONG_SYSTEM_PARAMETER],
        "compensations": [Command.GET_PROBE_COMPENSATION, Command.GET_T_CAM_TO_TRACKER_COMPENSATION],
    }[member]
    for command in lacking:
        fake.script[command] = lambda request: [Answer(request.command, ResultStatus.NOT_IMPLEMENTED)]

    tracker = await ready(fake)

    assert (await tracker.measure_pose(duration_s=1.0)).frames == 1
