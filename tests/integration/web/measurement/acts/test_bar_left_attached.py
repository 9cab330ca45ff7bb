"""A ballbar that an earlier session left attached keeps the arm where it is, whatever measures next."""

import asyncio
from typing import ClassVar

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import BALLBAR, WANTED, Tablet
from tests.integration.web.bench import CELL, SESSIONS, session_request
from tests.integration.web.contact_bench import GAUGE, WIRE
from tests.integration.web.measurement import test_camera_sessions as camera
from tests.integration.web.measurement.test_contact_sessions import FakeWire
from truepose_drivers.api import DriverPlugin
from truepose_drivers.registry import DriverRegistry

IN_ITS_BOX = "It lies in its box; I laid it there."


class Bench(camera.CameraBench):
    """Every instrument that a session may measure with."""

    def registry(self):
        wire = FakeWire(self.clock)
        plugin = DriverPlugin("fake_gauge", "linear_gauge", "fake", {}, lambda options, clock: wire)
        return DriverRegistry({**super().registry().plugins, plugin.name: plugin}, {})


class Kind:
    """How a session of one kind is asked for, and the cell that it runs in."""

    cells: ClassVar = {"tracker": CELL, "camera": camera.CELL, "contacts": CELL + GAUGE}

    def __init__(self, name):
        self.cell = self.cells[name] + BALLBAR
        self.path = "/api/v1/sessions"
        self.wanted = {"tracker": session_request(), "camera": camera.wanted(), "contacts": WIRE}[name]

    async def started(self, client):
        """Return the path of a session that asks a person."""
        path = (await client.post(self.path, json=self.wanted)).headers["Location"]
        assert (await command(client, path, "start")).status_code == 200
        return path


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture(params=["tracker", "camera", "contacts"])
def kind(request):
    return Kind(request.param)


@pytest.fixture
def cell_text(kind):
    return kind.cell


async def end_attached(client):
    """End a session with the ballbar that had asked for a length."""
    created = await client.post(SESSIONS, json=WANTED)
    tablet = Tablet(client, session_id=created.json()["id"])
    await tablet.press("start")
    async with asyncio.timeout(HANGS_S):
        while not any(line["kind"] == "shown" for line in await tablet.ledger()):
            await asyncio.sleep(0.005)
        await tablet.press("abort")
        while (await tablet.see())["state"] != "aborted":
            await asyncio.sleep(0.005)


def switch_off(bench):
    bench.ballbar.dead, bench.ballbar.connected = True, False


async def confirm(client, path, reason=None):
    said = {} if reason is None else {"reason": reason}
    return await command(client, path, "confirm", **said)


async def notes(client, path):
    return [note for note in (await client.get(path)).json()["notes"] if "ballbar" in note]


def assert_asks_how(refused):
    assert (refused.status_code, refused.json()["code"]) == (422, "TP-2006")
    assert "its removal was not detected" in refused.json()["detail"]


async def test_one_that_was_switched_off_since_takes_a_reason_that_counts_until_it_reads_a_length(
    client, bench, kind
):
    await end_attached(client)
    switch_off(bench)
    path = await kind.started(client)

    for nothing in (None, "  "):
        assert_asks_how(await confirm(client, path, nothing))
    assert bench.robot.moves == 0

    assert (await confirm(client, path, IN_ITS_BOX)).status_code == 200
    said = await notes(client, path)
    assert said == [f"Ada states how they know that the ballbar is off: {IN_ITS_BOX}"]

    await command(client, path, "abort")
    await ended(client, path)
    path = await kind.started(client)

    bench.ballbar.dead = False
    on_again = await confirm(client, path, IN_ITS_BOX)
    switch_off(bench)

    assert (on_again.status_code, on_again.json()["code"]) == (409, "TP-2001")
    assert_asks_how(await confirm(client, path))
    assert await notes(client, path) == ["The ballbar read a length within its range."]


async def test_so_does_it_where_the_service_was_restarted_since(settings, bench, kind):
    async with served(settings, bench.registry()) as client:
        await end_attached(client)
    again = Bench()
    switch_off(again)
    async with served(settings, again.registry()) as client:
        path = await kind.started(client)
        assert_asks_how(await confirm(client, path))
        assert again.robot.moves == 0
    async with served(settings, again.registry()) as client:
        assert_asks_how(await confirm(client, path))
        assert (await confirm(client, path, IN_ITS_BOX)).status_code == 200


async def test_a_session_that_the_ballbar_had_no_part_in_yet_does_not_vouch_for_it(client, bench, kind):
    await end_attached(client)
    unstarted = (await client.post(SESSIONS, json=WANTED)).json()["id"]
    await Tablet(client, session_id=unstarted).press("abort")
    switch_off(bench)

    assert_asks_how(await confirm(client, await kind.started(client)))


async def test_one_that_is_seen_to_come_off_is_asked_about_no_more(client, bench, kind):
    await end_attached(client)
    path = await kind.started(client)
    assert (await confirm(client, path)).status_code == 409  # it reads a length

    bench.ballbar.deviation_mm = 5.0

    assert (await confirm(client, path)).status_code == 200
    assert await notes(client, path) == ["Removal of the ballbar was detected."]


async def test_a_length_that_is_read_is_a_line_of_the_session_like_any_other(client, bench, kind):
    path = await kind.started(client)
    refused = await confirm(client, path)

    lines = (await client.get(f"{path}/ledger")).json()["entries"]
    shown = (await client.get(f"{path}/situation")).json()

    assert refused.status_code == 409
    assert lines[-1]["step_id"] == "ballbar-on"
    assert shown["ledger_number"] == lines[-1]["number"]


async def test_nobody_is_asked_where_no_session_left_it_attached(client, bench, kind):
    switch_off(bench)
    path = await kind.started(client)

    assert (await confirm(client, path)).status_code == 200
    assert await notes(client, path) == []


async def ended(client, path):
    async with asyncio.timeout(HANGS_S):
        while (await client.get(path)).json()["state"] not in {"aborted", "finished"}:
            await asyncio.sleep(0.005)
