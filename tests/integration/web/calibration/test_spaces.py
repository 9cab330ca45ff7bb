"""Errors in space over REST, of a stored result with the campaign that it is made from."""

import pytest

from tests.integration.web.calibration.conftest import OFF_MM


async def test_errors_are_seen_minus_foreseen_where_the_tool_stood(client, stored):
    space = (await client.get("/api/v1/identifications/1/space")).json()

    assert space["total"] == len(space["points_mm"]) == 5
    assert space["after_mm"] == [pytest.approx([0.0, 0.0, OFF_MM], abs=1e-5)] * 5
    assert space["poses"][0]["after_mm"] == pytest.approx(OFF_MM)
    assert all(len(piece) == 7 for piece in space["poses"][0]["pieces_mm"])


@pytest.mark.parametrize("path", ["identifications/2", "identifications/9", "validations/1", "diagnoses/1"])
async def test_what_has_no_model_has_no_errors_in_space(client, stored, path):
    answer = await client.get(f"/api/v1/{path}/space")

    assert answer.status_code == 404
    assert answer.json()["detail"].startswith("There is no ")


async def test_the_arm_of_a_configuration_that_is_asked_for_comes_first(client, stored):
    poses = (await client.get("/api/v1/identifications/1/space?config=4")).json()["poses"]

    assert [pose["config"] for pose in poses] == [4, 1, 2, 3, 5]
