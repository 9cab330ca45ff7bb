"""The simulated camera: what it sees, how well, and NDI's protocol in front of it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.ndi_polaris.protocol import (
    OKAY,
    DamagedRequest,
    PortStatus,
    Request,
    Text,
    decode_binary,
    decode_handles,
    decode_text,
    encode_reply,
    error_code,
    page_writes,
)
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import CameraFrozen, TrackerBlinded
from truepose_simulators.instruments.accuracy import CameraSetup
from truepose_simulators.instruments.camera import Camera
from truepose_simulators.instruments.ndi_polaris import Polaris, _Client
from truepose_simulators.physics.rigid import from_quaternion, inverse, move
from truepose_simulators.scenarios.file import load_scenario

LIMITS = SpeedLimits(500.0, 0.349)
FLAT, SPATIAL = "irb120-camera", "irb120-camera-spatial"


def cell_of(name=SPATIAL, seed=1, **camera):
    scenario = load_scenario(name)
    return Cell(replace(scenario, camera=replace(scenario.camera, **camera)), seed, CellClock(0))


def camera_of(cell):
    return Camera(cell, cell.scenario.camera)


async def go(cell, joints_deg):
    await cell.move_robot([np.radians(joints_deg)], LIMITS, np.zeros(3))


def stated_nests_mm(cell, seen):
    return np.array(cell.scenario.tool.nests_mm) @ from_quaternion(seen.quaternion).T + seen.position_mm


def true_nests_mm(cell, camera):
    return move(inverse(camera.frame), cell.nests_at_mm(cell.clock.now_s))


def somewhere(rng):
    return rng.uniform([-90, 0, -80, -150, -90, -180], [90, 90, 50, 150, 90, 180])


async def test_without_errors_a_pose_is_where_the_artefact_is():
    cell = cell_of(nest_mm=0.0, frame_mm=0.0, artefact_mm=0.0)
    camera = camera_of(cell)
    rng = np.random.default_rng(1)

    for _ in range(5):
        await go(cell, somewhere(rng))
        seen = camera.see(1)

        # the artefact's certificate is 0.002 per coordinate, five of it
        assert stated_nests_mm(cell, seen) == pytest.approx(true_nests_mm(cell, camera), abs=0.01)
        assert seen.rms_mm < 0.01


async def test_nests_err_by_what_the_scenario_states():
    cell = cell_of(artefact_mm=0.0)
    camera = camera_of(cell)
    errors_mm = []
    for number in range(150):
        await go(cell, [0.1 * number, 10, 10, 10, 10, 10])
        errors_mm.append(stated_nests_mm(cell, camera.see(1)) - true_nests_mm(cell, camera))

    # 0.045 of the stop and 0.010 of the frame, 900 values of freedom: 2.4 %, four of it
    assert np.sqrt(np.mean(np.square(errors_mm))) == pytest.approx(math.hypot(0.045, 0.010), rel=0.1)


async def test_the_artefacts_own_error_is_the_same_wherever_it_is():
    sizes = []
    for seed in range(60):
        cell = cell_of(seed=seed, nest_mm=0.0, frame_mm=0.0)
        camera = camera_of(cell)
        errors = []
        for joints_deg in ([0] * 6, [40, 20, -20, 50, 40, -60]):
            await go(cell, joints_deg)
            pose = camera.see(1)
            off_mm = stated_nests_mm(cell, pose) - true_nests_mm(cell, camera)
            errors.append(off_mm @ from_quaternion(pose.quaternion))
        assert errors[0] == pytest.approx(errors[1], abs=1e-4)  # turns of 1e-3 act on errors of 0.1
        sizes.append(errors[0])

    assert np.sqrt(np.mean(np.square(sizes))) == pytest.approx(0.040, rel=0.15)  # 360 of freedom: 3.7 %


async def test_an_arm_at_rest_is_seen_alike_but_for_single_frames():
    cell = cell_of()
    camera = camera_of(cell)
    await go(cell, [10] * 6)

    first, again, later = camera.see(1), camera.see(1), camera.see(2)
    await go(cell, [11] * 6)
    await go(cell, [10] * 6)
    back = camera.see(1)

    assert np.array_equal(first.position_mm, again.position_mm)
    assert 0.0 < math.dist(first.position_mm, later.position_mm) < 0.1  # 0.15 m from the nests
    assert math.dist(first.position_mm, back.position_mm) > 0.01


async def test_the_flat_artefact_is_seen_within_15_degrees_and_the_spatial_one_always():
    flat, spatial = cell_of(FLAT), cell_of(SPATIAL)
    cameras = camera_of(flat), camera_of(spatial)
    rng = np.random.default_rng(2)
    shown = []
    for _ in range(120):
        joints_deg = somewhere(rng)
        await go(flat, joints_deg)
        await go(spatial, joints_deg)
        nests = flat.nests_at_mm(flat.clock.now_s)
        normal = np.cross(nests[2] - nests[0], nests[1] - nests[0])
        line = cameras[0].frame[:3, 3] - nests.mean(axis=0)
        angle = math.degrees(math.acos(normal @ line / np.linalg.norm(normal) / np.linalg.norm(line)))
        assert (cameras[0].see(1) is not None) == (angle <= 15.0)
        assert cameras[1].see(1) is not None
        shown.append(angle <= 15.0)

    assert 0 < sum(shown) < 60


@pytest.mark.parametrize(
    "wrong",
    [{"reach_mm": 0.0}, {"nest_mm": -0.1}, {"frame_hz": 0.0}, {"position_mm": (0.0, 0.0, 900.0)}],
)
def test_a_camera_that_cannot_be_is_refused(wrong):
    with pytest.raises(ScenarioError, match="must"):
        CameraSetup(**wrong)


CELL = cell_of()  # its clock alone goes on between the examples


class Dialogue:
    """One client of a camera."""

    def __init__(self, cell):
        self.cell = cell
        self.polaris = Polaris(cell, cell.scenario.camera)
        self.client = _Client()

    async def ask(self, name, arguments=""):
        return await self.polaris.answer(Request(name, arguments), self.client)

    async def tracking(self):
        await self.ask("INIT")
        assert await self.ask("PHRQ", "*********1****") == Text("01")
        for write in page_writes(1, bytes(752)):
            assert await self.ask(write.name, write.arguments) == OKAY
        for name, arguments in (("PINIT", "01"), ("PENA", "01D"), ("TSTART", "80")):
            assert await self.ask(name, arguments) == OKAY
        return self


async def test_frames_count_the_cells_time_and_none_comes_twice():
    dialogue = await Dialogue(cell_of()).tracking()
    began_s = dialogue.cell.clock.now_s

    frames = [decode_binary(await dialogue.ask("BX", "0801"))[0].frame for _ in range(61)]

    assert frames == list(range(61))
    assert dialogue.cell.clock.now_s - began_s == pytest.approx(1.0, abs=0.001)


async def test_both_forms_tell_the_same():
    dialogue = await Dialogue(cell_of(frame_mm=0.0)).tracking()

    (binary,) = decode_binary(await dialogue.ask("BX", "0001"))
    (text,) = decode_text(await dialogue.ask("TX", "0001"))

    assert text.frame == binary.frame + 1
    assert text.status == binary.status == 0x31
    assert text.pose.quaternion == pytest.approx(binary.pose.quaternion, abs=0.6e-4)
    assert text.pose.position_mm == pytest.approx(binary.pose.position_mm, abs=0.006)


async def test_outside_the_volume_a_pose_is_told_to_whoever_asks_for_it():
    dialogue = await Dialogue(cell_of(reach_mm=1000.0)).tracking()

    (asked,) = decode_binary(await dialogue.ask("BX", "0801"))
    (not_asked,) = decode_binary(await dialogue.ask("BX", "0001"))

    assert asked.pose is not None
    assert not_asked.pose is None
    assert PortStatus.OUT_OF_VOLUME in asked.status & not_asked.status


async def test_a_blinded_camera_misses_its_tool_and_a_frozen_one_counts_no_frames():
    dialogue = await Dialogue(cell_of()).tracking()
    now_s = dialogue.cell.clock.now_s
    dialogue.cell.add_fault(TrackerBlinded(until_s=now_s + 0.1))

    (missing,) = decode_binary(await dialogue.ask("BX", "0801"))
    dialogue.cell.add_fault(CameraFrozen())
    frozen = [decode_binary(await dialogue.ask("BX", "0801"))[0].frame for _ in range(3)]

    assert missing.pose is None
    assert not missing.status & PortStatus.OUT_OF_VOLUME
    assert frozen == [missing.frame] * 3


@pytest.mark.parametrize(
    ("name", "arguments", "code"),
    [
        ("BX", "0801", 0x0C),
        ("TSTOP", "", 0x0C),
        ("PINIT", "01", 0x08),
        ("PHF", "zz", 0x07),
        ("PHSR", "77", 0x07),
        ("GETINFO", "Nothing.*", 0x34),
        ("LED", "", 0x01),
    ],
)
async def test_what_cannot_be_is_refused_by_number(name, arguments, code):
    dialogue = Dialogue(cell_of())
    await dialogue.ask("INIT")

    assert error_code(await dialogue.ask(name, arguments)) == code


async def test_nothing_is_loaded_before_initialising_and_nothing_changed_while_tracking():
    dialogue = Dialogue(cell_of())

    assert error_code(await dialogue.ask("PHRQ", "*********1****")) == 0x10
    await dialogue.tracking()
    assert error_code(await dialogue.ask("PHRQ", "*********1****")) == 0x0C


async def test_handles_pass_through_their_states_and_come_to_an_end():
    dialogue = Dialogue(cell_of())
    await dialogue.ask("INIT")
    handles = [await dialogue.ask("PHRQ", "*********1****") for _ in range(16)]

    assert [reply.text for reply in handles[:15]] == [f"{number:02X}" for number in range(1, 16)]
    assert error_code(handles[15]) == 0x2D
    assert error_code(await dialogue.ask("PINIT", "01")) == 0x0E  # nothing was loaded
    assert error_code(await dialogue.ask("PENA", "01D")) == 0x0E
    for write in page_writes(2, bytes(1)):
        await dialogue.ask(write.name, write.arguments)
    await dialogue.ask("PINIT", "02")
    assert decode_handles(await dialogue.ask("PHSR", "03")) == [(2, 0x11)]
    await dialogue.ask("PENA", "02S")
    assert decode_handles(await dialogue.ask("PHSR", "04")) == [(2, 0x31)]
    await dialogue.ask("PHF", "02")
    assert len(decode_handles(await dialogue.ask("PHSR", "00"))) == 14


@pytest.mark.parametrize(
    ("option", "lengths"),
    [("0001", [33]), ("0004", [20]), ("0008", [2]), ("0010", [2]), ("0020", [14]), ("0025", [33, 20, 14])],
)
async def test_a_tool_is_told_in_columns_of_fixed_lengths(option, lengths):
    dialogue = Dialogue(cell_of())
    await dialogue.ask("INIT")
    await dialogue.ask("PHRQ", "*********1****")

    told = (await dialogue.ask("PHINF", f"01{option}")).text

    assert len(told) == sum(lengths)
    if option.endswith(("1", "5")):
        assert (told[8:20], told[20:23], told[31:33]) == ("truepose    ", "001", "01")


@pytest.mark.parametrize("option", ["0000", "0040", "8001"])
async def test_what_no_source_lays_out_is_not_told_of_a_tool(option):
    dialogue = Dialogue(cell_of())
    await dialogue.ask("INIT")
    await dialogue.ask("PHRQ", "*********1****")

    assert error_code(await dialogue.ask("PHINF", f"01{option}")) == 0x07


NAMES = ["INIT", "VER", "PHSR", "PHRQ", "PVWR", "PINIT", "PENA", "PDIS", "PHF", "PHINF", "TSTART", "TX", "BX"]


@given(
    asked=st.lists(
        st.builds(
            Request,
            st.sampled_from(NAMES),
            st.text(st.sampled_from("0123456789ABCDEF-_ xD*"), max_size=8) | st.just("010000" + "4E" * 64),
        ),
        max_size=12,
    )
)
async def test_whatever_is_asked_is_answered(asked):
    dialogue = Dialogue(CELL)

    replies = [await dialogue.polaris.answer(request, dialogue.client) for request in asked]

    assert all(encode_reply(reply) for reply in replies)


@pytest.mark.parametrize(
    ("damaged", "code"),
    [(DamagedRequest(), 0x01), (DamagedRequest(checksum=True), 0x04), (DamagedRequest(too_long=True), 0x02)],
)
async def test_damaged_requests_are_refused(damaged, code):
    dialogue = Dialogue(cell_of())

    assert error_code(await dialogue.polaris.answer(damaged, dialogue.client)) == code
