"""A circle test as a session on a simulated cell, over REST: planned, measured, judged."""

import hashlib

import pytest

from tests.helpers.web.clients import measured, served
from truepose.reports.rounding import format_rounded
from truepose.settings import Settings

_TURNS = [{"joint": 5, "lower_deg": 35, "upper_deg": 90, "step_deg": 5}]
WANTED = {
    "name": "circles",
    "role": "validation",
    "plan": {"method": "circles", "turns": _TURNS},
    "registration_readings": 5,
}


@pytest.fixture
async def client(tmp_path):
    settings = Settings(f"sqlite:///{tmp_path}/truepose.sqlite3", simulated_pace=0)
    async with served(settings) as opened:
        yield opened


async def test_what_a_session_turned_is_found_as_a_circle_with_both_directions(client):
    path, session_id = await measured(client, WANTED)
    told = await client.get(f"{path}/circles")
    test = told.json()

    (one,) = test["circles"]
    direction = one["stops"]["direction"]
    assert (one["joint"], len(direction), one["set_aside"], test["withheld"]) == (5, 23, [], [])
    assert one["interval_deg"] == pytest.approx([35.0, 90.0], abs=0.02)
    # At the lower end it depends on where the arm came from.
    assert min(direction.count(1), direction.count(-1)) >= 11
    assert one["backlash_deg"] is not None

    page = (await client.get(f"/sessions/{session_id}/result")).text
    u = one["tangential_range_mm"]["standard_uncertainty"]
    assert f'<td class="n">{format_rounded(one["tangential_range_mm"]["value"], u)}</td>' in page
    assert hashlib.sha256(told.content).hexdigest() in page
