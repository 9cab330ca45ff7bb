"""A camera session over REST: planned, confirmed, read back, and the campaign that comes of it."""

from types import SimpleNamespace

import pytest

from tests.helpers.web.clients import command, until
from tests.integration.web.bench import Bench, session_request, stops
from tests.unit.service.sessions.tracker.test_camera_sessions import FakeCamera
from truepose.exchange.campaigns.zip_file import read_campaign_zip
from truepose_drivers.api import DriverPlugin
from truepose_drivers.registry import DriverRegistry

CELL = """
robot = "abb-irb-120"
robot_serial_number = "120-1"

[camera]
position_mm = [2200.0, 0.0, 900.0]
looks_at_mm = [0.0, 0.0, 0.0]
reading_u_mm = 0.045
artefact_u_mm = 0.040

[[device]]
name = "camera"
driver = "fake_camera"
serial_number = "P-1"

[[device]]
name = "robot"
driver = "fake_robot"
"""


class _Arm:
    """The robot of the bench, as the fake camera looks at it."""

    def __init__(self, robot):
        self._robot = robot

    @property
    def joints(self):
        return self._robot._joints_rad


class CameraBench(Bench):
    """The devices of a cell without a tracker."""

    def __init__(self):
        super().__init__()
        self.camera = FakeCamera(SimpleNamespace(clock=self.clock, robot=_Arm(self.robot)))

    def registry(self):
        plugin = DriverPlugin("fake_camera", "pose_tracker", "fake", {}, lambda options, clock: self.camera)
        return DriverRegistry({**super().registry().plugins, plugin.name: plugin}, {})


@pytest.fixture
def bench():
    return CameraBench()


@pytest.fixture
def cell_text():
    return CELL


def wanted(n=3):
    """Stops at which the artefact's centre is read."""
    at_the_centre = [{**stop, "nest": 4} for stop in stops(n)]
    return session_request(n, plan={"method": "given", "stops": at_the_centre})


async def measured(client):
    path = (await client.post("/api/v1/sessions", json=wanted())).headers["Location"]
    await command(client, path, "start")
    await command(client, path, "confirm")
    return path, await until(client, path, lambda session: session["state"] not in {"planned", "running"})


async def test_a_camera_session_is_planned_confirmed_and_told_pose_by_pose(client):
    path, session = await measured(client)

    plan = (await client.get(f"{path}/plan")).json()
    readings = (await client.get("/api/v1/readings")).json()

    assert (session["state"], session["measured"]) == ("finished", 3)
    assert session["registration"]["tracker_position_mm"] == [2200.0, 0.0, 900.0]
    assert session["registration"]["rms_mm"] is None
    assert plan["measures"] == "poses"
    assert [reading["kind"] for reading in readings] == ["point"] * 3
    point = readings[0]["point"]
    assert sum(part**2 for part in point["quaternion"]) == pytest.approx(1.0)
    assert 0.02 < point["rotation_uncertainty_deg"] < 0.04  # the triangle, 150 mm a side, read to 0.045


async def test_its_campaign_has_the_orientations_and_how_well_the_artefact_is_known(client):
    path, _ = await measured(client)

    made = await client.post(f"{path}/campaign", json={"name": "poses"})
    archive = await client.get(f"{made.headers['Location']}/archive")
    campaign = read_campaign_zip(archive.content)

    assert campaign.calibration.quaternion.shape == (3, 4)
    assert 4e-4 < campaign.tool_rotation_uncertainty_rad < 5e-4
    assert [nest.centre_mm for nest in campaign.nests][3] == pytest.approx((75.0, 31.225, 155.0))


async def test_another_camera_than_that_of_the_cell_file_is_questioned(client, bench):
    bench.camera.serial = "P-2"
    path = (await client.post("/api/v1/sessions", json=wanted())).headers["Location"]
    await command(client, path, "start")

    await command(client, path, "confirm")
    asked = await until(client, path, lambda session: session["tracker_in_question"] is not None)

    assert asked["tracker_in_question"]["serial_number"] == "P-2"
    assert (await client.get("/api/v1/readings")).json() == []
    assert bench.robot.moves == 0
