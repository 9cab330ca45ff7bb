"""Sessions of closed loops over REST: planned, asked for, run, read, made a campaign of."""

import asyncio

import pytest

from tests.helpers.web.clients import command, prompt_id
from tests.integration.web.bench import CELL, FakeLink
from tests.integration.web.contact_bench import GAUGE, WIRE
from truepose_drivers.api import BallbarReading, DriverPlugin
from truepose_drivers.registry import DriverRegistry


class FakeWire(FakeLink):
    """Shows one length, whatever hangs on it."""

    def __init__(self, clock):
        super().__init__("W1", "W-1")
        self._clock = clock

    async def read(self):
        return BallbarReading(12.5, "good", 1e-3, self._clock.time_s)


@pytest.fixture
def wire(bench, monkeypatch):
    """A wire in the cell."""
    made, plain = FakeWire(bench.clock), bench.registry().plugins
    plugin = DriverPlugin("fake_gauge", "linear_gauge", "fake", {}, lambda options, clock: made)
    monkeypatch.setattr(bench, "registry", lambda: DriverRegistry({**plain, "fake_gauge": plugin}, {}))
    return made


@pytest.fixture
def cell_text(request):
    return CELL + (GAUGE if "wire" in request.fixturenames else "")


async def test_a_session_is_planned_asked_for_run_and_made_a_campaign_of(wire, bench, client, until):
    made = await client.post("/api/v1/sessions", json=WIRE)
    path = made.headers["Location"]
    number = made.json()["id"]
    plan = (await client.get(f"/api/v1/sessions/{number}/plan")).json()

    started = await command(client, path, "start")
    asked = []
    for _ in plan["questions"]:
        shown = (await client.get(path)).json()
        assert shown["state"] == "awaiting_confirmation"
        assert bench.robot.moves == 0
        asked.append(shown["prompt"]["message"])
        reply = await command(client, path, "confirm", person="Ada Byron", prompt_id=shown["prompt"]["id"])
        assert reply.status_code == 200
        if len(asked) < len(plan["questions"]):
            while prompt_id((await client.get(path)).json()) in {None, shown["prompt"]["id"]}:
                pass
    finished = await until(path, "state", "finished")

    assert (made.status_code, made.json()["role"], started.status_code) == (201, "contacts", 200)
    assert asked == plan["questions"]
    assert (finished["planned"], finished["measured"], finished["skipped"]) == (6, 6, 0)
    readings = (await client.get(f"/api/v1/sessions/{number}/contact-readings")).json()
    assert [reading["reading_mm"] for reading in readings] == [[12.5]] * 6
    rest = await client.get(f"/api/v1/sessions/{number}/contact-readings?after=4")
    assert (rest.json(), rest.headers["Total-Count"], rest.links) == (readings[4:], "6", {})
    campaign = await client.post("/api/v1/campaigns", json={"name": "wire", "session_ids": [number]})
    assert campaign.json()["calibration_contacts"] == 6
    assert (await client.get(f"/api/v1/campaigns/{campaign.json()['id']}/archive")).status_code == 200


LATER = {"Prefer": "respond-async"}


async def in_thread(task, told):
    return await asyncio.to_thread(task.perform, lambda fraction, doing: None)


async def test_stops_are_chosen_by_a_job_where_that_is_preferred(wire, app, client, until):
    app.state.context.job_desk._queue._perform = in_thread
    waited_for = (await client.post("/api/v1/sessions", json=WIRE)).json()["id"]

    told = await client.post("/api/v1/sessions", json=WIRE, headers=LATER)
    job = await until(told.headers["Location"], "state", "succeeded", "failed")

    assert (told.status_code, told.headers["Preference-Applied"]) == (202, "respond-async")
    assert (job["kind"], job["request"]["configurations"]) == ("contact_plan", 6)
    assert (await client.get(job["result_url"])).json()["name"] == "one wire"
    one, other = [
        (await client.get(f"/api/v1/sessions/{number}/plan")).json()
        for number in (waited_for, job["result_id"])
    ]
    assert one == other
    assert (await client.get(f"/jobs/{job['id']}")).status_code == 200


async def test_a_choice_that_fails_says_so_in_its_job_and_leaves_no_session(app, client, until):
    app.state.context.job_desk._queue._perform = in_thread
    far = {**WIRE, "targets": [{"kind": "plane", "place_mm": [5000, 0, 0]}], "stroke_mm": 5, "margin_mm": 1}

    told = await client.post("/api/v1/sessions", json=far, headers=LATER)
    job = await until(told.headers["Location"], "state", "succeeded", "failed")

    assert (job["state"], job["code"]) == ("failed", "TP-5002")
    assert "Move the targets" in job["message"]
    assert (await client.get("/api/v1/sessions")).json() == []


async def test_the_same_request_plans_once(wire, client):
    key = {"Idempotency-Key": "plan-1"}

    first = await client.post("/api/v1/sessions", json=WIRE, headers=key)
    second = await client.post("/api/v1/sessions", json=WIRE, headers=key)

    assert first.json()["id"] == second.json()["id"]


async def test_a_cell_without_a_gauge_is_told_when_the_session_starts(client):
    made = await client.post("/api/v1/sessions", json=WIRE)

    reply = await command(client, made.headers["Location"], "start")

    assert reply.status_code == 409
    assert "no linear gauge" in reply.json()["detail"]


async def test_what_the_cell_cannot_do_is_refused_with_a_sentence(client):
    far = {**WIRE, "targets": [{"kind": "plane", "place_mm": [5000, 0, 0]}], "stroke_mm": 5, "margin_mm": 1}

    reply = await client.post("/api/v1/sessions", json=far)

    assert reply.status_code == 409
    assert "Move the targets" in reply.json()["detail"]


async def test_configurations_are_not_added_to_it(client):
    number = (await client.post("/api/v1/sessions", json=WIRE)).json()["id"]

    added = await client.post(
        f"/api/v1/sessions/{number}/configurations",
        json={"person": "Ada Byron", "configurations": [{"joints_deg": [0, 45, -30, 0, 30, 0]}]},
    )

    assert added.status_code == 409
    assert "closed loops" in added.json()["detail"]


async def test_nothing_read_is_no_campaign(client):
    number = (await client.post("/api/v1/sessions", json=WIRE)).json()["id"]

    reply = await client.post("/api/v1/campaigns", json={"name": "nothing", "session_ids": [number]})

    assert reply.status_code == 409
    assert "no reading" in reply.json()["detail"]


async def test_its_page_stands_where_those_of_all_sessions_do(client):
    number = (await client.post("/api/v1/sessions", json=WIRE)).json()["id"]

    page = await client.get(f"/sessions/{number}")
    listed = await client.get("/sessions")

    assert page.status_code == 200
    assert "Yes: continue" in page.text
    assert "closed loops" in listed.text
