"""Which instrument answers, over REST: expected and answered side by side, accepted by its number only."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import BALLBAR, WANTED, Tablet
from tests.integration.web.bench import CELL, SESSIONS, planned
from truepose.storage.ledger.sessions import SessionRepository

SESSION = "/api/v1/sessions/1"
NAMED = CELL.replace('driver = "fake_tracker"', 'driver = "fake_tracker"\nserial_number = "390003"')
BAR = '[ballbar.instrument]\nname = "QC20-W"\nserial_number = "B-7"\ncertificate = "C-1"\n'


@pytest.fixture
def cell_text():
    return NAMED + BALLBAR + BAR


async def connected(client, name):
    return (await client.post(f"/api/v1/devices/{name}/connect")).json()


async def test_a_device_shows_what_is_expected_and_what_it_answered(client):
    before = (await client.get("/api/v1/devices/tracker")).json()
    found = await connected(client, "tracker")

    assert (before["expected_serial_number"], before["answered_serial_number"]) == ("390003", None)
    assert (before["foreign"], before["certificate"]) == (False, "report 7")
    assert (found["expected_serial_number"], found["answered_serial_number"]) == ("390003", "42")
    assert (found["foreign"], found["certificate"]) == (True, "")


async def test_a_certificate_stays_with_the_device_whose_number_it_names(client, bench):
    bench.tracker.serial = "390003"

    found = await connected(client, "tracker")

    assert (found["foreign"], found["certificate"]) == (False, "report 7")


async def test_robot_and_ballbar_are_expected_as_the_cell_describes_them(client):
    robot, ballbar = await connected(client, "robot"), await connected(client, "ballbar")

    assert (robot["expected_serial_number"], robot["foreign"]) == ("120-1", False)
    assert (ballbar["expected_serial_number"], ballbar["foreign"]) == ("B-7", True)


async def test_a_device_that_tells_no_number_is_not_foreign(client, bench):
    bench.tracker.serial = "unknown"

    found = await connected(client, "tracker")

    assert (found["answered_serial_number"], found["foreign"]) == (None, False)


async def questioned(client, bench):
    bench.ballbar.dead = True  # nobody has it on the arm
    await planned(client)
    await command(client, SESSION, "start")
    await command(client, SESSION, "confirm")
    async with asyncio.timeout(HANGS_S):
        while "390003" not in str((found := (await client.get(SESSION)).json())["prompt"]):
            await asyncio.sleep(0.02)
    return found


async def test_a_session_asks_about_a_tracker_that_the_cell_file_does_not_name(client, until, bench):
    asked = await questioned(client, bench)
    assert asked["state"] == "awaiting_confirmation"
    assert "42" in asked["prompt"]["message"]
    assert asked["tracker_in_question"]["serial_number"] == "42"

    other = await command(client, SESSION, "confirm", accept_serial_number="43")
    accepted = await command(client, SESSION, "confirm", accept_serial_number="42")
    session = await until(SESSION, "state", "finished")

    assert other.status_code == 409
    assert accepted.status_code == 200
    assert {
        "device": "tracker",
        "finding": "accepted",
        "serial_number": "42",
        "expected_serial_number": "390003",
        "person": "Ada",
    } in session["identities"]
    assert session["tracker_in_question"] is None
    assert bench.robot.moves > 0
    readings = (await client.get(f"{SESSION}/readings")).json()
    assert {reading["instrument_serial"] for reading in readings} == {"42"}


async def test_a_confirmation_without_the_number_asks_again(client, until, bench):
    await questioned(client, bench)

    await command(client, SESSION, "confirm")
    session = await until(SESSION, "state", "awaiting_confirmation")

    assert "390003" in session["reason"]
    assert bench.robot.moves == 0
    assert (await client.get(f"{SESSION}/readings")).json() == []


async def test_whoever_polls_never_sees_the_reason_of_another_moment(client, bench, monkeypatch):
    """The record is read a while before the answer is written, and the session goes on meanwhile."""
    await questioned(client, bench)
    read = SessionRepository.get
    seen = []

    async def read_a_while_ago(self, session_id):
        record = await read(self, session_id)
        await asyncio.sleep(0.05)
        return record

    async def poll(offset_s):
        for _ in range(15):
            await asyncio.sleep(offset_s)
            found = (await client.get(SESSION)).json()
            seen.append((found["state"], found["reason"], found["prompt"] and found["prompt"]["message"]))

    monkeypatch.setattr(SessionRepository, "get", read_a_while_ago)
    confirming = command(client, SESSION, "confirm")
    await asyncio.gather(confirming, *(poll(0.004 + 0.001 * number) for number in range(6)))

    assert {state for state, _, _ in seen} <= {"awaiting_confirmation", "running"}
    for state, reason, question in seen:
        assert question == (reason if state == "awaiting_confirmation" else None)


async def test_a_ballbar_session_shows_the_one_in_question_and_who_accepted_it(client, bench):
    created = await client.post(SESSIONS, json=WANTED)
    assert created.status_code == 201, created.text
    tablet = Tablet(client)
    await tablet.press("start")
    async with asyncio.timeout(HANGS_S):
        while (seen := await tablet.see())["ballbar_in_question"] is None:
            await asyncio.sleep(0.02)
    assert seen["ballbar_in_question"]["expected_serial_number"] == "B-7"

    refused = await tablet.press("confirm")
    accepted = await tablet.press("confirm", accept_serial_number="42")
    seen = await tablet.see()

    assert refused.status_code == 409
    assert accepted.status_code == 200
    assert seen["ballbar_in_question"] is None
    assert ("accepted", "42", "Ada") in [
        (taken["finding"], taken["serial_number"], taken["person"]) for taken in seen["identities"]
    ]
    kept = [entry["identity"] for entry in await tablet.ledger() if entry["identity"] is not None]
    assert [taken["finding"] for taken in kept if taken["device"] == "ballbar"] == ["foreign", "accepted"]


async def test_the_start_page_says_where_another_device_answers(client):
    await connected(client, "tracker")

    page = (await client.get("/")).text

    assert "the cell file specifies 390003" in page


async def test_a_session_planned_for_another_robot_does_not_start(settings, bench):
    async with served(settings, bench.registry()) as client:
        await planned(client)
        await client.post(SESSIONS, json=WANTED)
    settings.cell_file.write_text(settings.cell_file.read_text().replace('"120-1"', '"120-2"'))
    bench.robot.serial = "120-2"

    async with served(settings, bench.registry()) as client:
        tracker = await command(client, SESSION, "start")
        ballbar = await Tablet(client, session_id=2).press("start")

    for refused in (tracker, ballbar):
        assert refused.status_code == 409
        assert "120-1" in refused.json()["detail"]
        assert "120-2" in refused.json()["detail"]
