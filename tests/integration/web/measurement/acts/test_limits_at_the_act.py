"""What the cell file says at the moment binds every motion, whatever was stored with a session."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import BALLBAR, WANTED, Tablet
from tests.integration.web.bench import CELL, SESSIONS, planned, session_request
from tests.integration.web.conftest import asking

TIGHT = "[limits]\njoints_deg = [[-5, 5], [-5, 5], [-5, 5], [-5, 5], [-5, 5], [-5, 5]]\n"
WIDE = "[limits]\ntool_speed_mm_s = 400.0\n"
SLOW = "[limits]\ntool_speed_mm_s = 50.0\norientation_speed_deg_s = 3.0\n"


class Service:
    """One database and one cell file; the service is started on them again and again."""

    def __init__(self, settings, bench):
        self.settings, self.bench = settings, bench
        self.speeds = []
        bench.robot.set_limits = self.set_limits
        bench.ballbar.dead = True  # unplugged: one between two balls forbids motion by itself

    async def set_limits(self, limits):
        self.speeds.append(limits)

    def write(self, limits):
        self.settings.cell_file.write_text(CELL + BALLBAR + limits)

    def started(self):
        return served(self.settings, self.bench.registry())

    async def planned_before(self, limits, wanted=None):
        """Plan a session; then the cell file says something else."""
        async with self.started() as client:
            await client.post(SESSIONS, json=wanted or session_request())
        self.write(limits)

    async def measures_a_planned_session_after(self, limits):
        await self.planned_before(limits)
        async with self.started() as client:
            await command(client, f"{SESSIONS}/1", "start")
            await command(client, f"{SESSIONS}/1", "confirm")
            await asking(client)(f"{SESSIONS}/1", "state", "finished")


@pytest.fixture
def service(settings, bench):
    made = Service(settings, bench)
    made.write(WIDE)
    return made


async def test_a_planned_session_outside_tightened_limits_does_not_start(service, bench):
    await service.planned_before(TIGHT)

    async with service.started() as client:
        refused = await command(client, f"{SESSIONS}/1", "start")
        session = (await client.get(f"{SESSIONS}/1")).json()

    assert refused.status_code == 409
    sentence = refused.json()["detail"]
    assert "configuration 1" in sentence
    assert "joint 2" in sentence
    assert "-5.00 to 5.00 deg" in sentence
    assert session["state"] == "planned"
    assert bench.robot.moves == 0


async def test_an_interrupted_session_is_refused_while_the_limits_are_tight_and_goes_on_later(service, bench):
    async with service.started() as client:
        await planned(client)
        bench.robot.gate.clear()
        await command(client, f"{SESSIONS}/1", "start")
        await command(client, f"{SESSIONS}/1", "confirm")
        await asyncio.wait_for(bench.robot.sent.wait(), HANGS_S)
    bench.robot.gate.set()
    moves = bench.robot.moves
    service.write(TIGHT)

    async with service.started() as client:
        refused = await command(client, f"{SESSIONS}/1", "confirm")
        waiting = (await client.get(f"{SESSIONS}/1")).json()
    assert refused.status_code == 409
    assert "joint 2" in refused.json()["detail"]
    assert waiting["state"] == "awaiting_confirmation"
    assert bench.robot.moves == moves

    service.write(WIDE)
    async with service.started() as client:
        await command(client, f"{SESSIONS}/1", "confirm")
        session = await asking(client)(f"{SESSIONS}/1", "state", "finished", "failed", "paused")
    assert (session["state"], session["measured"]) == ("finished", 3)


async def test_stored_limits_that_are_tighter_than_the_present_ones_still_bind(service):
    service.write("[limits]\ntool_speed_mm_s = 60.0\n")

    await service.measures_a_planned_session_after(WIDE)

    assert {limits.tool_speed_mm_s for limits in service.speeds} == {60.0}


async def test_the_robot_is_as_slow_as_the_cell_file_says_now(service, bench):
    await service.measures_a_planned_session_after(SLOW)

    assert bench.robot.moves > 0
    assert [limits.tool_speed_mm_s for limits in service.speeds] == [50.0]
    assert [limits.orientation_speed_rad_s for limits in service.speeds] == pytest.approx([0.0523599])


async def test_configurations_are_added_within_the_limits_of_now(service):
    await service.planned_before(TIGHT)

    async with service.started() as client:
        wanted = {"configurations": [{"joints_deg": [0, 40, -30, 0, 30, 0]}], "person": "Ada"}
        refused = await client.post(f"{SESSIONS}/1/configurations", json=wanted)

    assert refused.status_code == 409
    assert "joint 2" in refused.json()["detail"]


async def test_a_cell_file_that_has_changed_lets_nothing_move_before_a_restart(service, bench):
    async with service.started() as client:
        await planned(client)
        await command(client, f"{SESSIONS}/1", "start")
        service.write(SLOW)
        refused = await command(client, f"{SESSIONS}/1", "confirm")
        service.write("this is no TOML")
        unreadable = await command(client, f"{SESSIONS}/1", "confirm")
        ended = await command(client, f"{SESSIONS}/1", "abort")

    assert (refused.status_code, unreadable.status_code) == (409, 409)
    assert "restart the service" in refused.json()["detail"]
    assert "can no longer be read" in unreadable.json()["detail"]
    assert ended.status_code == 200
    assert bench.robot.moves == 0


async def test_a_comment_in_the_cell_file_stops_nobody(service):
    async with service.started() as client:
        await planned(client)
        await command(client, f"{SESSIONS}/1", "start")
        service.write(WIDE + "# checked on Monday\n")

        assert (await command(client, f"{SESSIONS}/1", "confirm")).status_code == 200


async def test_another_robot_than_the_one_planned_for_does_not_move(service):
    async with service.started() as client:
        await planned(client)
    other = service.settings.cell_file.read_text().replace("abb-irb-120", "fanuc-lr-mate-200ic")
    service.settings.cell_file.write_text(other)

    async with service.started() as client:
        refused = await command(client, f"{SESSIONS}/1", "start")

    assert refused.status_code == 409
    assert "planned for robot ABB IRB 120" in refused.json()["detail"]


async def test_a_ballbar_session_is_found_again_and_refused_until_the_limits_allow_it(service, bench):
    async with service.started() as client:
        await client.post(SESSIONS, json=WANTED)
        await Tablet(client).press("start")
    service.write(TIGHT)

    async with service.started() as client:
        tablet = Tablet(client, "tablet-2")
        found = await tablet.see()
        await tablet.press("hand_over")
        refused = await tablet.press("confirm")
        still = await tablet.see()
    assert found["state"] == still["state"] == "awaiting_confirmation"
    assert refused.status_code == 409
    assert "placement-1/cup-1/move" in refused.json()["detail"]
    assert "joint 1" in refused.json()["detail"]

    service.write(SLOW)
    async with service.started() as client:
        tablet = Tablet(client, "tablet-3")
        await tablet.press("hand_over")
        assert (await tablet.press("confirm")).status_code == 200
        assert (await tablet.see())["state"] == "running"
    assert bench.robot.moves == 0
    assert service.speeds[-1].tool_speed_mm_s == 50.0


async def test_a_ballbar_session_does_not_start_outside_the_limits_of_now(service):
    await service.planned_before(TIGHT, WANTED)

    async with service.started() as client:
        refused = await Tablet(client).press("start")
        ended = await Tablet(client).press("abort", key="end")

    assert refused.status_code == 409
    assert "joint 1" in refused.json()["detail"]
    assert ended.status_code == 200
