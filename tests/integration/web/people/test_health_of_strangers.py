"""Health tells a stranger how the service is, and nothing of the shop."""

import pytest

from truepose.domain.people import Role

HTML = {"Accept": "text/html"}


@pytest.fixture
def house_in_trouble(house):
    house.app.state.context.database.condition.note_damage(
        "planted", "Record 3 of the readings is not as it was."
    )
    return house


async def test_a_supervisor_without_an_account_learns_that_the_service_lives(house):
    async with house.client() as stranger:
        health = (await stranger.get("/health")).json()

    assert {"status", "version", "simulated", "schema", "verdict"} <= health.keys()
    assert health["checks"] == []


async def test_a_stranger_does_not_learn_what_is_amiss(house_in_trouble):
    async with house_in_trouble.client() as stranger:
        health = (await stranger.get("/health")).json()
        page = (await stranger.get("/health", headers=HTML)).text
        sign_in = (await stranger.get("/sign-in", headers=HTML)).text

    assert (health["status"], health["verdict"]) == ("degraded", "bad")
    assert health["fault"] == "There is a problem; sign in for details."
    assert "Record 3" not in page + sign_in


async def test_whoever_may_see_the_cell_learns_it(house_in_trouble):
    async with house_in_trouble.of(Role.VIEWER) as viewer:
        health = (await viewer.get("/health")).json()
        page = (await viewer.get("/health", headers=HTML)).text

    assert "Record 3" in health["fault"]
    assert {check["name"]: check["verdict"] for check in health["checks"]}["chain"] == "bad"
    assert "Record 3" in page


async def test_figures_are_for_whoever_may_look(house):
    async with house.client() as stranger, house.of(Role.VIEWER) as viewer:
        assert (await stranger.get("/metrics")).status_code == 401
        assert (await viewer.get("/metrics")).status_code == 200
