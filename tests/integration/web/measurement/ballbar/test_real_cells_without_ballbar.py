"""A cell without a ballbar says so in one sentence."""

from tests.integration.web.ballbar_bench import SESSIONS, WANTED


async def test_a_cell_without_a_ballbar_plans_no_ballbar_session(client):
    refused = await client.post(SESSIONS, json=WANTED)

    assert refused.status_code == 409
    assert "[ballbar]" in refused.json()["detail"]


async def test_at_a_real_cell_no_hands_are_simulated(client):
    told = await client.get("/api/v1/simulated-hands")
    refused = await client.post("/api/v1/simulated-hands", json={"action": "detach"})

    assert told.json() == {"simulated": False, "actions": [], "holding": ""}
    assert refused.status_code == 409
