"""Given stops at which the arm would touch floor, table or itself are refused, and at the act too."""

import pytest

from service.app import create_app
from tests.integration.web.bench import CELL, session_request, stops
from tests.integration.web.test_sessions import connected

SESSIONS = "/api/v1/sessions"
BELOW = [0.0, 90.0, 0.0, 0.0, 90.0, 0.0]  # the tool looks down from the outstretched arm
ON_A_PEDESTAL = "[base_in_world]\nx_mm = 0\ny_mm = 0\nz_mm = 800\nrx_deg = 0\nry_deg = 0\nrz_deg = 0\n"
LOW_FLOOR = "[limits]\nfloor_z_mm = -300\n"


def given(*joints_deg):
    return {
        "method": "given",
        "stops": [stop | {"joints_deg": q} for stop, q in zip(stops(9), joints_deg, strict=False)],
    }


async def test_a_stop_with_a_nest_below_the_table_is_refused_with_stop_body_and_depth(client):
    refused = await client.post(SESSIONS, json=session_request(plan=given(stops(1)[0]["joints_deg"], BELOW)))

    assert refused.status_code == 409
    sentence = refused.json()["detail"]
    assert "configuration 2" in sentence
    assert "tool nest" in sentence
    assert "mm below floor or table" in sentence


async def test_an_approach_below_the_table_is_refused(client):
    wanted = session_request(plan=given(BELOW), approach_offset_deg=20.0)

    assert (await client.post(SESSIONS, json=wanted)).status_code == 409


@pytest.mark.parametrize("base", [ON_A_PEDESTAL, LOW_FLOOR])
async def test_a_robot_that_stands_high_or_has_a_low_floor_may_go_there(settings, bench, base):
    settings.cell_file.write_text(CELL.replace("[[fixed_nest]]", base + "[[fixed_nest]]", 1))
    app = create_app(settings, bench.registry())
    async with app.router.lifespan_context(app), connected(app) as client:
        answer = await client.post(SESSIONS, json=session_request(plan=given(BELOW)))

    assert answer.status_code == 201, answer.text


async def test_a_floor_that_is_stated_higher_since_binds_at_the_start(settings, bench):
    for floor, path in (("", SESSIONS), ("[limits]\nfloor_z_mm = 900.0\n", f"{SESSIONS}/1/start")):
        settings.cell_file.write_text(CELL + floor)
        app = create_app(settings, bench.registry())
        async with app.router.lifespan_context(app), connected(app) as client:
            answer = await client.post(path, json=None if floor else session_request())

    assert answer.status_code == 409
    assert "below floor or table" in answer.json()["detail"]
    assert bench.robot.moves == 0
