"""A sphere test as a session on a simulated cell, over REST: planned, measured, judged."""

import asyncio
import hashlib

import pytest

from tests.helpers.machine import HANGS_S
from tests.studies.interruptions.killed_service import standing_service
from truepose.demo.simulated_operator import SimulatedOperator
from truepose.exchange.campaigns.folder import read_campaign
from truepose.exchange.campaigns.zip_file import write_campaign_zip
from truepose.reports.rounding import format_rounded
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.files import write_campaign as write_recorded
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

_PLACE = {"x_mm": 350, "y_mm": -150, "z_mm": 150, "ry_deg": -30, "rz_deg": 60}
_PLAN = {"method": "sphere", "configurations": 7, "nests": [1]}


@pytest.fixture
async def service(tmp_path):
    async with standing_service("irb120-everyday", 2, tmp_path) as client:
        yield client


async def _identified(service, folder):
    """Have the service identify this very arm from a tracker's campaign; returns the model's number."""
    write_recorded(record(load_scenario("irb120-everyday").quiet(), 2, RecordingRequest(60, 0)), folder)
    archive = write_campaign_zip(read_campaign(folder))
    sent = await service.post(
        "/api/v1/campaigns", content=archive, headers={"Content-Type": "application/zip"}
    )
    job = await service.post("/api/v1/identifications", json={"campaign_id": sent.json()["id"]})
    assert job.status_code == 202, job.text
    async with asyncio.timeout(HANGS_S):
        while not (models := (await service.get("/api/v1/models")).json()):
            await asyncio.sleep(0.1)
    return models[0]["id"]


async def test_a_model_that_commanded_the_arm_is_judged_about_the_ball_that_it_held(service, tmp_path):
    model = await _identified(service, tmp_path / "campaign")
    wanted = {"name": "sphere", "placements": [_PLACE], "plan": _PLAN | {"model_id": model}}
    created = await service.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
    assert created.status_code == 201, created.text
    number = created.json()["id"]
    assert (await service.get(f"/api/v1/sessions/{number}/sphere")).status_code == 409  # nothing is read yet
    person = SimulatedOperator(service, number)

    session = await person.walk()

    assert session["state"] == "finished", session["reason"]
    told = await service.get(f"/api/v1/sessions/{number}/sphere")
    test = told.json()
    (ball,) = test["spheres"]
    steps = (await service.get(f"{person.path}/plan")).json()["steps"]
    measured = [step["id"] for step in steps if "/leg-1-1" in step["id"] and step["outcome"] == "measured"]
    assert (len(ball["config"]), test["skipped"]) == (len(measured), 0) == (7, 0)
    assert [one["model"] for one in test["order"]] == [f"model {model}", "nominal"]
    by_model = next(one for one in ball["errors"] if one["model"] == f"model {model}")
    # It has every stop on its own sphere: its errors are on the bar itself.
    assert by_model["centre"] == "taught"
    assert by_model["error_mm"] == pytest.approx(ball["shown_mm"], abs=1e-3)

    assert session["result_url"] == f"/sessions/{number}/result"
    page = (await service.get(session["result_url"])).text
    for one in ball["errors"]:
        mean = one["figures"][0]["mean_mm"]
        assert f'<td class="n">{format_rounded(mean["value"], mean["standard_uncertainty"])}</td>' in page
    assert hashlib.sha256(told.content).hexdigest() in page
    assert f'href="/sessions/{number}/result"' in (await service.get("/sessions")).text
