"""A whole ballbar session on a simulated cell, over REST, and what becomes of it."""

import asyncio
import contextlib

import pytest

from tests.helpers.machine import HANGS_S
from tests.integration.web.ballbar_bench import PLACE, PLACEMENT
from tests.studies.interruptions.killed_service import standing_service
from truepose.demo.errors import RequestRefusedError
from truepose.demo.simulated_operator import SimulatedOperator
from truepose.exchange.campaigns.zip_file import read_campaign_zip

OFF = "It lies beside the arm."  # where the moment at which it came off was missed


@pytest.fixture
async def service(tmp_path):
    async with standing_service("lrmate-tilted", 2, tmp_path) as client:
        yield client


async def ended(client, path):
    async with asyncio.timeout(HANGS_S):
        while (job := (await client.get(path)).json())["state"] in {"queued", "running"}:
            await asyncio.sleep(0.1)
    return job


async def test_a_session_with_simulated_hands_becomes_a_campaign_that_identifies_the_robot(service):
    # To look for a place takes as long as all else here: tests/unit/service/planning/ballbar
    wanted = {"name": "six legs", "poses": 13, "placements": [PLACE]}
    created = await service.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
    assert created.status_code == 201, created.text
    person = SimulatedOperator(service, created.json()["id"])

    session = await person.walk()

    assert session["state"] == "finished", session["reason"]
    assert not [said for said in person.refusals if "does not fit" not in said]  # too far apart may happen
    entries = (await service.get(f"{person.path}/ledger", params={"limit": 1000})).json()["entries"]
    (found,) = [entry["precalibration"] for entry in entries if entry["kind"] == "computed"][:1]
    assert found["exchanged"] == []
    assert found["rms_mm"] < 0.05

    stored = await service.post("/api/v1/campaigns", json={"name": "mine", "session_ids": [session["id"]]})
    assert stored.status_code == 201, stored.text
    campaign = read_campaign_zip((await service.get(stored.json()["archive_url"])).content)
    measured = {entry["step_id"] for entry in entries if entry["kind"] == "measured"}
    assert len(campaign.legs) == len([step for step in measured if "/leg-" in step])
    assert len(campaign.setup.placement) == 3

    job = await service.post("/api/v1/identifications", json={"campaign_id": stored.json()["id"]})
    assert (await ended(service, job.headers["Location"]))["state"] == "succeeded"


async def refused(said):
    """Return the refusal to confirm; a machine that stands still for a second knows nothing and asks why."""
    async with asyncio.timeout(HANGS_S):
        while True:
            with contextlib.suppress(RequestRefusedError):
                answer = await said("confirm")
                assert answer.status_code == 409
                return answer


async def test_what_the_ballbar_shows_outranks_what_the_person_says(service):
    wanted = {"name": "in a hurry", "placements": [PLACEMENT]}
    created = await service.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
    assert created.status_code == 201, created.text
    person = SimulatedOperator(service, created.json()["id"])

    async def said(act, **more):
        step = (await person.session())["step"]
        return await person.act(act, step["id"], **more)

    await person.walk("tool/side-1-2")
    assert (await said("store")).is_success  # on the calibrator still
    assert (await person.session())["suspicion"]["kind"] == "calibrator"
    await said("answer", answer="reconnected")

    await person.walk("tool/detach")
    left_on = await refused(said)
    assert "within its range" in left_on.json()["detail"]
    await person.hands("hold")
    assert (await said("confirm", reason=OFF)).is_success

    move = "placement-1/cup-1/move"
    await person.walk(move)
    await person.hands("calibrator", bars="base")
    await refused(said)
    await person.hands("detach")
    assert (await said("confirm", reason=OFF)).is_success
    await person.walk("placement-1/cup-1/clamp")
