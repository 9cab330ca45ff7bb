"""Jobs over REST: their progress, their results, their end by request or by accident."""

import asyncio
import dataclasses
import math

import numpy as np
import pytest

from tests.helpers.domain.builders import (
    make_identification,
    make_model,
    make_pair,
    make_parameter,
    make_points,
)
from tests.helpers.web.clients import served
from tests.integration.web.bench import uploaded
from truepose.analysis.errors import WorkerDiedError
from truepose.analysis.job_queue.supervisor import TaskRefusedError
from truepose.analysis.job_queue.tasks import CirclePlanTask, IdentifyTask, PlanTask, PosePlanTask
from truepose.domain.session import PlannedStop, Turn
from truepose.domain.validation import Validation
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.records import JobKind

# An angle that is told in degrees, of a model without a measured zone; the arm's own scatter is not known.
ANGLE = make_parameter(name="theta_2")
MODEL = make_model(parameters=(ANGLE,), covariance=np.eye(1) * 1e-10, repeatability_mm=float("nan"))
IDENTIFIED = make_identification(model=MODEL, cross_validation=make_pair(noise_mm=0.019))


class FakeWorker:
    """Answers with dull results; `gate` holds it, `error` makes it fail."""

    def __init__(self):
        self.gate = asyncio.Event()
        self.gate.set()
        self.error = None
        self.asked = None
        self.cancelled = 0

    async def __call__(self, task, told):
        await told(0.25, "reading the campaign")
        try:
            await self.gate.wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        if self.error is not None:
            raise self.error
        if isinstance(task, IdentifyTask):
            return IDENTIFIED
        if isinstance(task, PlanTask):
            stops = tuple(PlannedStop(k + 1, (0.0,) * 6, 1) for k in range(task.n_configurations))
            return dataclasses.replace(task.template, stops=stops)
        if isinstance(task, CirclePlanTask | PosePlanTask):
            self.asked = task
            return dataclasses.replace(task.template, stops=(PlannedStop(1, (0.0,) * 6, 1),))
        return Validation("position", make_pair(), None, None, passed=True)


@pytest.fixture
def worker():
    return FakeWorker()


@pytest.fixture
async def campaign_id(client):
    return await uploaded(client, validation=make_points())


async def identification_job(client, campaign_id, **headers):
    answer = await client.post("/api/v1/identifications", json={"campaign_id": campaign_id}, headers=headers)
    assert answer.status_code == 202, answer.text
    return answer.headers["Location"]


@pytest.fixture
async def identified(client, until, campaign_id):
    """The job of an identification that has succeeded."""
    job = await until(await identification_job(client, campaign_id), "state", "succeeded", "failed")
    assert job["state"] == "succeeded", job["message"]
    return job


@pytest.fixture
async def model_id(client, identified):
    return (await client.get(identified["result_url"])).json()["model_id"]


async def test_an_identification_leaves_its_document_and_a_model(client, identified):
    found = (await client.get(identified["result_url"])).json()
    model = (await client.get(f"/api/v1/models/{found['model_id']}")).json()
    file = await client.get(model["file_url"])

    assert (identified["fraction"], identified["code"], identified["code_url"]) == (1.0, None, None)
    assert found["document"]["status"] == "converged"
    assert "validation" not in found["document"]["statistics"]
    assert found["document"]["statistics"]["cross_validation"]["identified"]["noise_mm"] == 0.019
    assert model["parameters"][0]["unit"] == "deg"
    assert model["parameters"][0]["value"] == pytest.approx(0.0572957795)
    assert model["repeatability_mm"] is None
    assert file.json()["format"] == "truepose-model"
    assert "attachment" in file.headers["content-disposition"]


@pytest.mark.parametrize(("form", "begins"), [("urdf", '<?xml version="1.0"'), ("dhm", "elbow")])
async def test_a_model_is_downloaded_for_other_programs(client, model_id, form, begins):
    file = await client.get(f"/api/v1/models/{model_id}/exports/{form}")

    assert file.status_code == 200, file.text
    assert file.text.startswith(begins)
    assert f"model-{model_id}" in file.headers["content-disposition"]


async def test_what_no_format_can_hold_is_a_problem_in_words(client, model_id):
    models = f"/api/v1/models/{model_id}/exports"

    other_arm, zoneless, no_format = [
        await client.get(f"{models}/{form}") for form in ("ros", "controller", "sdf")
    ]

    assert [answer.status_code for answer in (other_arm, zoneless, no_format)] == [409, 409, 422]
    assert "does not state its measured zone" in zoneless.json()["detail"]
    assert "elbow does not have the axes of a Universal Robots arm" in other_arm.json()["detail"]
    assert (await client.get("/api/v1/models/999/exports/urdf")).status_code == 404


async def test_a_model_is_validated_on_a_campaign(client, until, campaign_id, model_id):
    asked = await client.post("/api/v1/validations", json={"model_id": model_id, "campaign_id": campaign_id})
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    found = (await client.get(job["result_url"])).json()

    assert found["document"]["pass"] is True
    assert found["document"]["position"]["nominal"]["n"] == 10


async def test_a_running_job_shows_how_far_it_is_and_can_be_cancelled(client, until, worker, campaign_id):
    worker.gate.clear()
    path = await identification_job(client, campaign_id)

    running = await until(path, "message", "reading the campaign")
    cancelled = await client.post(f"{path}/cancel")
    again = await client.post(f"{path}/cancel")

    assert (running["state"], running["fraction"] >= 0.25) == ("running", True)
    assert cancelled.json()["state"] == "cancelled"
    assert worker.cancelled == 1
    assert again.status_code == 409
    assert again.json()["detail"] == "Job 1 has already been cancelled."
    assert (await client.get("/api/v1/identifications")).json() == []


async def test_jobs_wait_for_each_other_and_a_waiting_one_can_be_cancelled(
    client, until, worker, campaign_id
):
    worker.gate.clear()
    first = await identification_job(client, campaign_id)
    second = await identification_job(client, campaign_id)
    third = await identification_job(client, campaign_id)
    await until(first, "state", "running")
    await until(second, "state", "running")

    waiting = (await client.get(third)).json()
    await client.post(f"{third}/cancel")
    worker.gate.set()

    assert (waiting["state"], waiting["ahead_count"], waiting["remaining_s"]) == ("queued", 0, None)
    assert (await until(first, "state", "succeeded"))["result_id"] is not None
    assert (await client.get(third)).json()["state"] == "cancelled"


async def test_what_is_short_does_not_wait_for_what_is_long(client, until, worker, campaign_id):
    worker.gate.clear()
    diagnoses = [await client.post("/api/v1/diagnoses", json={"campaign_id": campaign_id}) for _ in range(3)]
    first, *others = [answer.headers["Location"] for answer in diagnoses]
    await until(first, "state", "running")

    short = await identification_job(client, campaign_id)
    running = await until(short, "state", "running")

    assert [(await client.get(path)).json()["state"] for path in others] == ["queued", "queued"]
    assert running["remaining_s"] > 0


async def test_what_was_learnt_of_earlier_jobs_foretells_the_next_one(app, identified):
    (taken,) = await app.state.context.jobs.taken(JobKind.IDENTIFICATION, 15)

    assert taken.work_count == identified["request"]["work_count"] > 0
    assert 0 <= taken.duration_s < 10


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (TaskRefusedError("campaign.json: there are no readings.", "TP-4014"), "TP-4014"),
        (TaskRefusedError("The program failed at this task (KeyError: 3); please report it."), "TP-5007"),
        (WorkerDiedError("The worker process was ended by signal SIGKILL before it answered."), "TP-5006"),
    ],
)
async def test_a_job_that_fails_keeps_the_sentence_and_its_code(
    client, until, worker, campaign_id, error, code
):
    worker.error = error

    job = await until(await identification_job(client, campaign_id), "state", "failed")
    page = await client.get(f"/jobs/{job['id']}")

    assert job["message"] == str(error)
    assert job["result_id"] is None
    assert (job["code"], job["code_url"]) == (code, f"/errors/{code}")
    assert f'href="/errors/{code}"' in page.text
    assert (await client.get(job["code_url"])).status_code == 200


async def test_a_fault_of_the_program_does_not_leave_a_job_running(client, until, worker, campaign_id):
    worker.error = ZeroDivisionError("division by zero")

    job = await until(await identification_job(client, campaign_id), "state", "failed")

    assert job["message"].startswith("The program failed (ZeroDivisionError: division by zero)")
    assert job["code"] == "TP-9001"


async def test_a_result_waits_for_a_disk_that_refuses_and_is_kept_when_it_takes_records_again(
    client, until, app, worker, campaign_id, monkeypatch
):
    held = app.state.context.database.backend
    worker.gate.clear()
    path = await identification_job(client, campaign_id)
    await until(path, "message", "reading the campaign")

    def refuse():
        raise StorageUnavailableError("The disk is full.")

    with monkeypatch.context() as full:
        full.setattr(held, "make_ready", refuse)
        worker.gate.set()
        waiting = await until(
            path,
            "message",
            "The result of the job is held in memory until the database accepts records again. "
            "The disk is full.",
        )
        refused = await client.post(f"{path}/cancel")
    ended = await until(path, "state", "succeeded", "failed", "cancelled")

    assert (waiting["state"], refused.status_code) == ("running", 503)
    assert ended["state"] == "succeeded", ended["message"]
    assert (await client.get(ended["result_url"])).json()["document"]["status"] == "converged"


async def test_a_job_asked_twice_with_one_key_runs_once(client, until, campaign_id):
    key = {"Idempotency-Key": "i-1"}
    first = await identification_job(client, campaign_id, **key)
    await until(first, "state", "succeeded")

    assert await identification_job(client, campaign_id, **key) == first
    assert len((await client.get("/api/v1/jobs")).json()) == 1


async def test_a_restart_marks_unfinished_jobs_as_interrupted(settings, bench, worker):
    worker.gate.clear()
    async with served(settings, bench.registry(), worker) as client:
        path = await identification_job(client, await uploaded(client))

    async with served(settings, bench.registry(), worker) as client:
        job = (await client.get(path)).json()

    assert job["state"] == "interrupted"
    assert "service was stopped" in job["message"]


async def test_without_readings_of_its_kind_no_job_is_queued(client, model_id):
    wanted = {"model_id": model_id, "campaign_id": await uploaded(client)}

    refused = await client.post("/api/v1/validations", json=wanted)

    assert (refused.status_code, len((await client.get("/api/v1/jobs")).json())) == (409, 1)
    assert "no validation readings" in refused.json()["detail"]


async def test_what_is_not_there_cannot_be_identified(client):
    refused = await client.post("/api/v1/identifications", json={"campaign_id": 7})

    assert refused.status_code == 404
    assert refused.json()["detail"] == "There is no campaign 7."


@pytest.mark.parametrize(
    ("effects", "sentence"),
    [
        (["base", "geometry", "base"], "Effect 'base' is given twice. Give it once."),
        (["magic"], "'magic'; available effects: base, tool"),
    ],
)
async def test_effects_that_cannot_be_meant_are_refused_at_once(client, campaign_id, effects, sentence):
    wanted = {"campaign_id": campaign_id, "effects": effects}
    refused = await client.post("/api/v1/identifications", json=wanted)

    assert refused.status_code == 422
    assert sentence in refused.json()["detail"]
    assert (await client.get("/api/v1/jobs")).json() == []


async def test_configurations_are_chosen_by_a_job_whose_result_is_the_session(client, until):
    wanted = {"name": "a", "role": "validation", "plan": {"method": "choose", "configurations": 5}}

    asked = await client.post("/api/v1/sessions", json=wanted)
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    session = (await client.get(job["result_url"])).json()

    assert asked.status_code == 202
    assert (job["kind"], job["state"]) == ("plan", "succeeded"), job["message"]
    assert (session["name"], session["role"], session["planned"]) == ("a", "validation", 5)


async def test_the_job_that_plans_a_proof_names_the_model_and_nothing_is_proved_yet(client, until, model_id):
    plan = {"method": "prove", "model_id": model_id, "targets": 4}

    asked = await client.post("/api/v1/sessions", json={"name": "p", "role": "validation", "plan": plan})
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    proof = await client.get(f"{job['result_url']}/proof", params={"model_id": model_id})

    assert (job["state"], job["request"]["proves_model_id"]) == ("succeeded", model_id), job["message"]
    assert proof.status_code == 409
    assert "no readings of a tool nest; run the session first" in proof.json()["detail"]


_TURN = {"joint": 6, "lower_deg": -180, "upper_deg": 180, "step_deg": 90}
_CUBE = {"edge_mm": 200, "centre_mm": [370, 0, 400], "cycles": 2}


@pytest.mark.parametrize(
    ("plan", "understood"),
    [
        ({"method": "circles"}, {"turns": ()}),
        (
            {"method": "circles", "turns": [_TURN]},
            {"turns": (Turn(6, -math.pi, math.pi, math.pi / 2),)},
        ),
        (
            {"method": "iso9283", **_CUBE},
            {"centre_mm": (370.0, 0.0, 400.0), "edge_mm": 200.0, "plane": "y+", "nest": None, "cycles": 2}
            | {"quaternion": None, "test": "poses"},
        ),
        (
            {"method": "iso9283", "test": "directions", "approach_mm": 30},
            {"test": "directions", "approach_mm": 30.0, "cycles": 30, "centre_mm": None},
        ),
        ({"method": "iso9283", "test": "drift", "hours": 0.5}, {"test": "drift", "hours": 0.5}),
    ],
)
async def test_tests_of_the_trade_are_planned_by_a_job(client, until, worker, plan, understood):
    wanted = {"name": "t", "role": "validation", "plan": plan}

    asked = await client.post("/api/v1/sessions", json=wanted)
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")

    assert asked.status_code == 202
    assert (job["state"], job["request"]["method"]) == ("succeeded", plan["method"]), job["message"]
    assert (await client.get(job["result_url"])).json()["planned"] == 1
    assert {name: getattr(worker.asked, name) for name in understood} == understood


_PROOF = {"method": "prove", "model_id": 1, "targets": 4}


@pytest.mark.parametrize("plan", [{"method": "circles"}, {"method": "iso9283", **_CUBE}, _PROOF])
async def test_what_a_test_or_a_proof_reads_never_identifies(client, plan):
    refused = await client.post("/api/v1/sessions", json={"name": "t", "role": "calibration", "plan": plan})

    assert refused.status_code == 409
    assert 'set the role of the session to "validation"' in refused.json()["detail"]


async def test_a_model_that_there_is_not_is_not_proved(client):
    wanted = {"name": "p", "role": "validation", "plan": _PROOF}

    assert (await client.post("/api/v1/sessions", json=wanted)).status_code == 404
