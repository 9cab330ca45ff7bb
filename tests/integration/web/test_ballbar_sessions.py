"""Ballbar sessions over REST."""

import pytest

SIMULATED = """
[simulated]
scenario = "irb120-tilted"
"""
PLACEMENT = {
    "x_mm": 350.0,
    "y_mm": 0.0,
    "z_mm": 50.0,
    "cups_mm": [[350.0, 0.0, 50.0], [650.0, 0.0, 50.0], [500.0, 260.0, 50.0]],
    "setups": [{"base_point": k, "joints_deg": [10.0 * k, 20, 10, 0, 30, 0]} for k in (1, 2, 3)],
    "poses": [
        {
            "config": k,
            "joints_deg": [5.0 * k, 20, 0, 0, 40, 0],
            "legs": [[1, 1], [1, 2], [2, 2], [2, 3], [3, 3], [3, 1]],
        }
        for k in (1, 2)
    ],
}
WANTED = {"name": "six legs", "placements": [PLACEMENT]}


@pytest.fixture
def settings(settings, tmp_path):
    with settings.cell_file.open("a") as cell_file:
        cell_file.write("\n[ballbar]\nbase_points = 3\n")
    return settings


async def act(client, number, name, key, **said):
    body = {"act": name, "person": "Ada", "tablet": "t1", **said}
    return await client.post(
        f"/api/v1/ballbar-sessions/{number}/acts", json=body, headers={"Idempotency-Key": key}
    )


async def test_a_planned_session_lists_its_steps_before_the_start(client):
    created = await client.post("/api/v1/ballbar-sessions", json=WANTED)

    assert created.status_code == 201, created.text
    session = created.json()
    steps = (await client.get(f"{created.headers['Location']}/steps")).json()["steps"]
    assert (session["state"], session["step"]["id"], session["acts"]) == (
        "planned",
        "tool/initialise",
        ["abort", "start"],
    )
    assert {step["outcome"] for step in steps} == {"open"}
    assert [step["points"] for step in steps if step["id"].startswith("tool/side")] == [
        ["T1", "T2"],
        ["T2", "T3"],
        ["T1", "T3"],
    ]


async def test_a_repeated_act_gets_the_same_answer_and_is_done_once(client):
    await client.post("/api/v1/ballbar-sessions", json=WANTED)

    first = (await act(client, 1, "start", "k1")).json()
    again = (await act(client, 1, "start", "k1")).json()

    assert (again["sentence"], again["entry"]) == (first["sentence"], first["entry"])
    assert first["session"]["state"] == "running"
    entries = (await client.get("/api/v1/ballbar-sessions/1/ledger")).json()["entries"]
    assert [entry["number"] for entry in entries if entry["key"] == "k1"] == [first["entry"]]


async def test_the_key_of_an_act_is_not_for_another_act(client):
    await client.post("/api/v1/ballbar-sessions", json=WANTED)
    await act(client, 1, "start", "k1")

    refused = await act(client, 1, "abort", "k1")

    assert refused.status_code == 409
    assert "another act" in refused.json()["detail"]
