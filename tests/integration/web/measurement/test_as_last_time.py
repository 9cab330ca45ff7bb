"""A plan used again: what it takes over, what is said to be different, and what is refused."""

import re

import pytest

from tests.helpers.web.clients import served
from tests.integration.web.ballbar_bench import BALLBAR, SESSIONS, WANTED
from tests.integration.web.bench import CELL, session_request
from tests.integration.web.contact_bench import WIRE


@pytest.fixture
def cell_text():
    return CELL + BALLBAR


async def planned(client, path, wanted):
    answer = await client.post(path, json=wanted)
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


async def again(client, until, number, **wanted):
    asked = await client.post(f"/api/v1/sessions/{number}/again", json={"name": "November", **wanted})
    assert asked.status_code == 202, asked.text
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    assert job["state"] == "succeeded", job["message"]
    return int(job["result_url"].rsplit("/", 1)[1])


async def test_the_same_stops_are_planned_once_more_and_nothing_moves(client, until):
    first = await planned(client, "/api/v1/sessions", session_request(n=4, settle_s=7.5))

    second = await again(client, until, first, attachment=2)

    plans = [(await client.get(f"/api/v1/sessions/{number}/plan")).json() for number in (first, second)]
    assert plans[0] == plans[1]
    shown = (await client.get(f"/api/v1/sessions/{second}")).json()
    assert (shown["name"], shown["state"], shown["role"]) == ("November", "planned", "calibration")


async def test_a_ballbar_session_keeps_its_placements_and_legs(client, until):
    first = await planned(client, SESSIONS, WANTED)

    second = await again(client, until, first)

    steps = [(await client.get(f"{SESSIONS}/{number}/plan")).json()["steps"] for number in (first, second)]
    assert steps[0] == steps[1]


async def test_a_session_of_closed_loops_keeps_its_targets_and_stops(client, until):
    first = await planned(client, "/api/v1/sessions", WIRE)

    second = await again(client, until, first)

    plans = [(await client.get(f"/api/v1/sessions/{number}/plan")).json() for number in (first, second)]
    assert plans[0] == plans[1]
    assert (await client.get(f"/sessions/{second}/again")).status_code == 200


async def test_some_of_the_stops_are_planned_alone(client, until):
    first = await planned(client, "/api/v1/sessions", session_request(n=4))

    second = await again(client, until, first, configurations=[4, 2])

    whole, some = [
        (await client.get(f"/api/v1/sessions/{number}/plan")).json()["stops"] for number in (first, second)
    ]
    assert some == [whole[1], whole[3]]
    page = (await client.get(f"/sessions/{first}/again?configurations=2&configurations=4")).text
    assert "Only these configurations: 2, 4." in page
    assert "&#34;configurations&#34;: [2, 4]" in page


async def test_a_contact_session_is_planned_again_in_part(client, until):
    first = await planned(client, "/api/v1/sessions", WIRE)
    stops = (await client.get(f"/api/v1/sessions/{first}/plan")).json()["stops"]

    second = await again(client, until, first, configurations=[stops[-1]["config"]])

    assert (await client.get(f"/api/v1/sessions/{second}/plan")).json()["stops"] == stops[-1:]


async def test_stops_that_are_not_there_or_belong_together_are_not_planned_alone(client):
    tracker = await planned(client, "/api/v1/sessions", session_request(n=3))
    ballbar = await planned(client, SESSIONS, WANTED)

    unknown, whole = [
        await client.post(f"/api/v1/sessions/{n}/again", json={"name": "x", "configurations": [9]})
        for n in (tracker, ballbar)
    ]

    assert (unknown.status_code, whole.status_code) == (409, 409)
    assert f"Session {tracker} has no configuration 9" in unknown.json()["detail"]
    assert "belong together: repeat all of them" in whole.json()["detail"]
    assert (await client.get(f"/sessions/{tracker}/again?configurations=9")).status_code == 409


async def test_as_many_stops_are_chosen_anew_where_they_belong_to_no_test(client, until):
    first = await planned(client, "/api/v1/sessions", session_request(n=3))

    second = await again(client, until, first, poses="anew")

    stops = [(await client.get(f"/api/v1/sessions/{n}/plan")).json()["stops"] for n in (first, second)]
    chosen = [stop for stop in stops[1] if stop["repeat_of"] is None]
    assert len(chosen) == 3
    assert all(stop["joints_deg"] not in [one["joints_deg"] for one in stops[0]] for stop in chosen)


async def test_a_test_stays_the_test_it_was(client, until):
    asked = await client.post(
        "/api/v1/sessions",
        json=session_request(role="validation", plan={"method": "iso9283", "cycles": 2, "test": "poses"}),
    )
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    first = int(job["result_url"].rsplit("/", 1)[1])

    second = await again(client, until, first)

    titles = [
        re.search(r'class="under">[^<]*', (await client.get(f"/sessions/{n}")).text) for n in (first, second)
    ]
    assert [title[0].split("·")[1] for title in titles] == [" ISO 9283 test "] * 2
    refused = await client.post(f"/api/v1/sessions/{first}/again", json={"name": "x", "poses": "anew"})
    assert refused.status_code == 409
    assert "form a fixed set" in refused.json()["detail"]


async def test_where_the_cell_is_the_same_nothing_is_said_to_differ(client):
    first = await planned(client, "/api/v1/sessions", session_request(n=3))

    page = (await client.get(f"/sessions/{first}/again")).text

    assert "The cell file is unchanged since the earlier session" in page
    assert "have changed" not in page and "has changed" not in page
    assert f'href="/sessions/{first}"' in page


async def test_what_changed_since_is_said_before_anything_is_planned(settings, bench, worker):
    async with served(settings, bench.registry(), worker) as client:
        first = await planned(client, "/api/v1/sessions", session_request(n=3))
    expired = CELL.replace(
        'certificate = "report 7"', 'certificate = "report 7"\ncertificate_expires = 2020-01-31'
    )
    settings.cell_file.write_text(expired.replace("[2600.0,", "[2500.0,"))

    async with served(settings, bench.registry(), worker) as client:
        page = (await client.get(f"/sessions/{first}/again")).text

    for sentence in ("Devices have changed", "position has changed", "2020-01-31"):
        assert sentence in page
    assert "The robot has a different serial number" not in page


async def test_a_plan_of_another_robot_is_refused(settings, bench, worker):
    async with served(settings, bench.registry(), worker) as client:
        first = await planned(client, "/api/v1/sessions", session_request(n=3))
    settings.cell_file.write_text(CELL.replace("abb-irb-120", "fanuc-lr-mate-200ic"))

    async with served(settings, bench.registry(), worker) as client:
        refused = await client.post(f"/api/v1/sessions/{first}/again", json={"name": "x"})
        page = (await client.get(f"/sessions/{first}/again")).text

    assert refused.status_code == 409
    assert "cannot be used here" in refused.json()["detail"] and "its plan cannot be used here" in page
    assert "data-asks" not in page


@pytest.mark.parametrize("number", ["99", "x"])
async def test_what_there_was_not_cannot_be_used_again(client, number):
    assert (await client.get(f"/sessions/{number}/again")).status_code == 404


async def test_only_what_was_measured_is_offered(client):
    await planned(client, "/api/v1/sessions", session_request(n=3))

    assert 'id="again"' not in (await client.get("/sessions/new")).text
