"""The proof move on a simulated cell, over REST: measure, identify, correct, measure again."""

import hashlib

import pytest

from tests.helpers.web.clients import made, measured, served
from truepose.reports.rounding import millimetres
from truepose.settings import Settings

CALIBRATION = {
    "name": "calibration",
    "role": "calibration",
    "plan": {"method": "choose", "configurations": 35, "seed": 1},
    "registration_readings": 5,
}
PROOF = {"name": "proof", "role": "validation", "registration_readings": 5}


@pytest.fixture
async def client(tmp_path):
    settings = Settings(f"sqlite:///{tmp_path}/truepose.sqlite3", simulated_pace=0)
    async with served(settings) as opened:
        yield opened


async def test_a_correction_is_proved_on_the_robot_that_it_was_made_for(client):
    first, session_id = await measured(client, CALIBRATION)
    campaign = await client.post(f"{first}/campaign", json={"name": "c"})
    identified = await made(
        client, await client.post("/api/v1/identifications", json={"campaign_id": campaign.json()["id"]})
    )
    model_id = (await client.get(identified)).json()["model_id"]
    plan = {"method": "prove", "model_id": model_id, "targets": 12, "seed": 3}

    path, proof_id = await measured(client, PROOF | {"plan": plan})
    told = await client.get(f"{path}/proof", params={"model_id": model_id})
    proof = told.json()
    calibration = await client.get(f"/api/v1/sessions/{session_id}/proof", params={"model_id": model_id})

    assert proof["targets"] == 12
    assert proof["proved"], proof
    assert proof["gain"] > 10.0
    assert proof["after"]["mean_mm"] < 0.06  # tracker 0.025, model 0.02
    assert abs(proof["foretold_share"] - 1.0) < 0.1
    assert calibration.status_code == 422
    assert "These readings cannot prove this model" in calibration.json()["detail"]

    page = (await client.get(f"/sessions/{proof_id}/result")).text
    for kind in ("before", "after", "before_relative", "after_relative"):
        for figure in ("mean_mm", "rms_mm", "sd_mm", "max_mm"):
            assert f'<td class="n">{millimetres(proof[kind][figure])}</td>' in page
    assert f"{proof['gain']:.3g} times" in page
    assert hashlib.sha256(told.content).hexdigest() in page  # what the page shows is that document
    model = await client.get(f"/api/v1/models/{model_id}/file")
    assert hashlib.sha256(model.content).hexdigest() in page
    assert f'href="/sessions/{proof_id}/result"' in (await client.get("/sessions")).text

    judged = await client.get(f"{path}/accuracy", params={"model_id": model_id, "limit_mm": 5})
    assert judged.json()["decision"]["verdict"] == "conforms"
    assert judged.json()["iso9283"] is None
