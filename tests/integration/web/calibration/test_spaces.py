"""Errors of a stored result with the campaign that it is made from: in space, in columns, and as a page."""

import pytest

from tests.integration.web.calibration.conftest import OFF_MM


async def test_errors_are_seen_minus_foreseen_where_the_tool_stood(client, stored):
    space = (await client.get("/api/v1/identifications/1/space")).json()

    assert space["total"] == len(space["points_mm"]) == 5
    assert space["after_mm"] == [pytest.approx([0.0, 0.0, OFF_MM], abs=1e-5)] * 5
    assert space["poses"][0]["after_mm"] == pytest.approx(OFF_MM)
    assert all(len(piece) == 7 for piece in space["poses"][0]["pieces_mm"])


@pytest.mark.parametrize("path", ["identifications/2", "identifications/9", "validations/1", "diagnoses/1"])
async def test_what_has_no_model_has_no_errors(client, stored, path):
    space, residuals = [await client.get(f"/api/v1/{path}/{what}") for what in ("space", "residuals")]
    page = await client.get(f"/{path}/readings")

    assert [answer.status_code for answer in (space, residuals, page)] == [404] * 3
    assert space.json()["detail"].startswith("There is no ")


async def test_the_arm_of_a_configuration_that_is_asked_for_comes_first(client, stored):
    poses = (await client.get("/api/v1/identifications/1/space?config=4")).json()["poses"]

    assert [pose["config"] for pose in poses] == [4, 1, 2, 3, 5]


async def test_readings_come_in_columns(client, stored):
    told = (await client.get("/api/v1/identifications/1/residuals")).json()

    assert told["config"] == [1, 2, 3, 4, 5]
    assert told["after_mm"] == [pytest.approx([0.0, 0.0, OFF_MM], abs=1e-5)] * 5
    assert [(one["name"], one["joint"]) for one in told["variables"]][:4] == [
        ("joint", 1),
        ("joint", 2),
        ("joint", 3),
        ("reach", None),
    ]
    assert {len(one["values"]) for one in told["variables"]} == {5}


async def test_the_page_of_a_result_leads_to_its_readings(client, stored):
    assert 'href="/identifications/1/readings"' in (await client.get("/identifications/1")).text
    assert "/readings" not in (await client.get("/identifications/2")).text
    assert (await client.get("/identifications/1/readings")).status_code == 200
