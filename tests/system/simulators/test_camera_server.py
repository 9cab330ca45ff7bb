"""A cell with a camera in a process of its own, and the drivers at its sockets."""

import math

import pytest

from tests.helpers.machine import NDICAPI
from tests.system.simulators.cell_process import started_cell
from truepose.demo.truth import cell_endpoint
from truepose_drivers.errors import ArtefactNotSeenError, LinkError

CAMERA_MM = (2200.0, 0.0, 900.0)


@pytest.fixture
def definition(tmp_path):
    """A file that defines an artefact."""
    path = tmp_path / "artefact.rom"
    path.write_bytes(bytes(752))
    return str(path)


async def camera_of(cell, definition):
    clock = await cell.connected("cell_clock", "clock")
    camera = await cell.connected("ndi_polaris", "camera", clock, tool_file=definition)
    await camera.initialise()
    return camera


def nest_seen_mm(reading, nest_mm):
    """A place of the artefact in the camera's frame: v + 2 q x (q x v + w v)."""
    (w, *q), v = reading.quaternion, nest_mm
    inner = [a + w * b for a, b in zip(cross(q, v), v, strict=True)]
    turned = [a + 2.0 * b for a, b in zip(v, cross(q, inner), strict=True)]
    return [a + b for a, b in zip(turned, reading.position_mm, strict=True)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


async def test_poses_of_the_spatial_artefact_until_the_camera_hangs(definition):
    nests_mm = [(45.0, 0.0, 150.0), (-22.5, 38.971, 150.0), (-22.5, -38.971, 150.0)]
    async with started_cell("irb120-camera-spatial", "--pace", "0") as cell:
        camera = await camera_of(cell, definition)

        identity = await camera.identify()
        reading = await camera.measure_pose(duration_s=1.0)
        async with cell_endpoint(**cell.address("truth")) as truth:
            true_mm = (await truth.ask("positions", joints_rad=[[0.0] * 6]))["positions_mm"][0]

        assert (identity.model, identity.serial) == ("Polaris Vega VT", "P9-10000")
        assert reading.frames == pytest.approx(60, abs=1)
        assert all(0.0 < deviation < 0.05 for deviation in reading.position_deviation_mm)
        for nest, true in zip(nests_mm, true_mm, strict=True):
            seen = nest_seen_mm(reading, nest)
            # The stand is about there, 5 mm a coordinate, five of it.
            assert math.hypot(*seen) == pytest.approx(math.dist(true, CAMERA_MM), abs=25.0)
            # Between two nests the place of the stand is gone: 0.045 and 0.040 a coordinate, six of it.
            first = nest_seen_mm(reading, nests_mm[0])
            assert math.dist(seen, first) == pytest.approx(math.dist(true, true_mm[0]), abs=0.5)

        async with cell_endpoint(**cell.address("truth")) as truth:
            await truth.ask("fault", kind="camera_frozen")
        with pytest.raises(LinkError, match="do not advance"):
            await camera.measure_pose(duration_s=1.0)
        assert not camera.connected


async def test_the_flat_artefact_is_not_seen_from_the_side(definition):
    async with started_cell("irb120-camera", "--pace", "0") as cell:
        camera = await camera_of(cell, definition)

        with pytest.raises(ArtefactNotSeenError, match="did not see the artefact in"):
            await camera.measure_pose(duration_s=0.5)

        assert camera.connected


def poses_by_ndicapy(client, port, definition):
    """What the public client reads: positions in text and in binary, and what it is told of a wrong mode."""
    device = client.ndiOpenNetwork("127.0.0.1", port)
    client.ndiCommand(device, "INIT:")
    client.ndiCommand(device, "PHRQ:*********1****")
    handle = client.ndiGetPHRQHandle(device)
    client.ndiPVWRFromFile(device, handle, definition)
    for command in (f"PINIT:{handle:02X}", f"PENA:{handle:02X}D", "TSTART:", "TX:0801", "BX:0801", "TSTOP:"):
        client.ndiCommand(device, command)
    by_text = client.ndiGetTXTransform(device, bytes([handle]))
    by_bytes = client.ndiGetBXTransform(device, bytes([handle]))
    with pytest.raises(OSError, match="0x0c"):
        client.ndiCommand(device, "TX:0801")
    client.ndiCloseNetwork(device)
    return by_text, by_bytes


async def test_the_public_client_ndicapy_reads_the_pose_that_the_driver_reads(definition):
    client = pytest.importorskip("ndicapy", reason=NDICAPI.reason)
    async with started_cell("irb120-camera-spatial", "--pace", "0") as cell:
        by_text, by_bytes = poses_by_ndicapy(client, cell.address("camera")["port"], definition)
        camera = await camera_of(cell, definition)  # after a program that left its handle behind
        reading = await camera.measure_pose(duration_s=1.0)

    ours = (*reading.quaternion, *reading.position_mm, reading.rms_mm)
    for theirs in (by_text, by_bytes):
        # A frame turns by 0.010 mm over 45 mm and moves the origin, 0.15 m before the nests; five of it.
        assert theirs[:4] == pytest.approx(ours[:4], abs=1.2e-3)
        assert theirs[4:7] == pytest.approx(ours[4:7], abs=0.2)
        assert theirs[7] == pytest.approx(ours[7], abs=0.05)
