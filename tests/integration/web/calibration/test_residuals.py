"""Readings of stored results over REST and as a page."""

import pytest

from tests.integration.web.calibration.conftest import OFF_MM


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


@pytest.mark.parametrize("path", ["identifications/2", "identifications/9", "validations/1", "diagnoses/1"])
async def test_what_has_no_model_has_no_errors_of_readings(client, stored, path):
    answer, page = await client.get(f"/api/v1/{path}/residuals"), await client.get(f"/{path}/readings")

    assert (answer.status_code, page.status_code) == (404, 404)


async def test_the_page_of_a_result_leads_to_its_readings(client, stored):
    assert 'href="/identifications/1/readings"' in (await client.get("/identifications/1")).text
    assert "/readings" not in (await client.get("/identifications/2")).text
    assert (await client.get("/identifications/1/readings")).status_code == 200
