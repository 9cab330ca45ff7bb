"""Diagnoses over REST: asked for, stored with their model, compared over time."""

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis, make_finding, make_unexplained
from tests.helpers.domain.builders import make_robot
from tests.integration.web.bench import CELL, Bench, begun, measured, planned, uploaded
from tests.integration.web.diagnosing import Diagnostician, served
from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.exchange.results.diagnosis import diagnosis_document

DIAGNOSES = "/api/v1/diagnoses"


@pytest.fixture
def worker():
    return Diagnostician()


@pytest.fixture
def diagnosed(client, until):
    """Diagnose a campaign and return the path of the diagnosis."""

    async def ask(campaign_id, **request):
        asked = await client.post(DIAGNOSES, json={"campaign_id": campaign_id, **request})
        assert asked.status_code == 202, asked.text
        job = await until(asked.headers["Location"], "state", "succeeded", "failed")
        assert job["state"] == "succeeded", job["message"]
        return job["result_url"]

    return ask


async def test_a_diagnosis_leaves_its_document_and_a_model(client, diagnosed):
    found = (await client.get(await diagnosed(await uploaded(client)))).json()
    model = (await client.get(f"/api/v1/models/{found['model_id']}")).json()
    file = (await client.get(model["file_url"])).json()

    assert found["document"] == diagnosis_document(make_diagnosis())
    assert (found["session_id"], found["robot_serial_number"]) == (None, None)
    assert (model["diagnosis_id"], model["identification_id"]) == (found["id"], None)
    assert model["parameters"][0]["name"] == "backlash_3"
    assert file["effects"] == ["base", "geometry", "backlash"]


async def test_the_job_says_what_it_was_asked_and_what_it_found(client, until, worker):
    number = await uploaded(client)

    asked = await client.post(
        DIAGNOSES,
        json={"campaign_id": number, "effects": ["base", "tool", "geometry"], "measured_on": "2026-03-03"},
    )
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")

    assert (job["kind"], job["message"]) == ("diagnosis", make_diagnosis().message)
    assert job["request"]["effects"] == ["base", "tool", "geometry"]
    assert job["request"]["measured_on"] == "2026-03-03"
    assert worker.tasks[0].effects == ("base", "tool", "geometry")


async def test_where_nothing_could_be_fitted_there_is_no_model(client, diagnosed, worker):
    worker.found = [make_unexplained(model=None, before=None, after=None)]

    found = (await client.get(await diagnosed(await uploaded(client)))).json()

    assert (found["model_id"], found["document"]["verdict"]) == (None, "unexplained")
    assert (await client.get("/api/v1/models")).json() == []


async def test_a_list_shows_first_lines_and_findings_without_drawings(client, diagnosed):
    await diagnosed(await uploaded(client))

    (listed,) = (await client.get(DIAGNOSES)).json()

    assert (listed["verdict"], listed["message"]) == ("explained", make_diagnosis().message)
    assert listed["findings"] == [
        {
            "effect": "backlash",
            "subject": "joint 3",
            "amplitude": 0.021,
            "unit": "deg",
            "amplitude_standard_uncertainty": 0.003,
            "confidence": "likely",
        }
    ]


async def test_joint_3_is_compared_with_spring(client, diagnosed, worker):
    worker.found = [
        make_diagnosis(findings=(make_finding(amplitude=a, amplitude_standard_uncertainty=u),))
        for a, u in ((0.033, 0.0032), (0.021, 0.0024))
    ]
    await diagnosed(await uploaded(client), measured_on="2026-10-02")
    await diagnosed(await uploaded(client), measured_on="2026-03-03")

    compared = (await client.get(f"{DIAGNOSES}/comparison", params={"robot": "elbow"})).json()

    (cause,) = compared["causes"]
    assert [entry["measured_at"] for entry in compared["diagnoses"]] == ["2026-03-03", "2026-10-02"]
    assert [sign["diagnosis_id"] for sign in cause["signs"]] == [2, 1]
    assert cause["changes"][0]["difference"] == pytest.approx(0.012)
    assert cause["changes"][0]["significant"] is True
    assert "grew by 0.0120 ± 0.0040 deg between 2026-03-03 and 2026-10-02" in cause["changes"][0]["sentence"]


async def test_readings_without_a_day_stand_last_and_nothing_is_subtracted_from_them(client, diagnosed):
    await diagnosed(await uploaded(client))
    await diagnosed(await uploaded(client), measured_on="2026-10-02")

    compared = (await client.get(f"{DIAGNOSES}/comparison", params={"robot": "elbow"})).json()

    assert [entry["measured_at"] for entry in compared["diagnoses"]] == ["2026-10-02", None]
    assert compared["undated_ids"] == [1]
    assert compared["causes"][0]["changes"] == []


async def test_what_is_simulated_says_so_with_its_diagnosis_and_nothing_else_does(client, diagnosed):
    told = [
        (await client.get(await diagnosed(await uploaded(client, **said)))).json()["simulated"]
        for said in ({"simulated": True}, {"simulated": False}, {}, {"notes": ("SIMULATED: no robot.",)})
    ]

    assert told == [True, False, False, True]
    assert [entry["simulated"] for entry in (await client.get(DIAGNOSES)).json()] == told
    assert [entry["simulated"] for entry in (await client.get("/api/v1/campaigns")).json()] == told


async def test_of_two_diagnoses_of_the_same_readings_the_latest_counts(client, diagnosed):
    number = await uploaded(client)
    await diagnosed(number)
    await diagnosed(number, effects=["base", "geometry"])

    compared = (await client.get(f"{DIAGNOSES}/comparison", params={"robot": "elbow"})).json()

    assert [entry["id"] for entry in compared["diagnoses"]] == [2]
    assert compared["causes"][0]["changes"] == []


async def test_robots_of_another_name_are_not_compared(client, diagnosed):
    await diagnosed(await uploaded(client))
    await diagnosed(await uploaded(client, robot=make_robot(name="wrist")))

    compared = (await client.get(f"{DIAGNOSES}/comparison", params={"robot": "wrist"})).json()

    assert [entry["robot"] for entry in compared["diagnoses"]] == ["wrist"]


@pytest.mark.parametrize("query", [{"robot": "nobody"}, {"robot": "elbow", "serial_number": "7"}])
async def test_a_robot_without_diagnoses_is_said(client, diagnosed, query):
    await diagnosed(await uploaded(client))

    refused = await client.get(f"{DIAGNOSES}/comparison", params=query)

    assert refused.status_code == 404
    assert "No diagnosis of robot" in refused.json()["detail"]


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        ({"effects": ["magic"]}, "'magic'; available effects: base, tool"),
        ({"effects": ["geometry", "geometry"]}, "'geometry' is given twice"),
        ({"measured_on": "3 March"}, "measured_on"),
        ({"measured_on": 20260303}, "measured_on"),
        ({"effects": []}, "effects"),
        ({"session_id": 1}, "session_id"),
    ],
)
async def test_a_request_that_cannot_be_meant_is_refused(client, request_, words):
    refused = await client.post(DIAGNOSES, json={"campaign_id": await uploaded(client), **request_})

    assert refused.status_code == 422
    assert words in refused.json()["detail"]


async def test_what_is_not_there_cannot_be_diagnosed(client):
    campaign = await client.post(DIAGNOSES, json={"campaign_id": 7})
    session = await client.post("/api/v1/sessions/8/diagnosis", json={})
    diagnosis = await client.get(f"{DIAGNOSES}/9")

    assert [answer.status_code for answer in (campaign, session, diagnosis)] == [404] * 3
    assert diagnosis.json()["detail"] == "There is no diagnosis 9."


async def test_the_readings_of_a_session_are_diagnosed_and_dated_by_the_last_of_them(client, until):
    path = await measured(client, until)

    asked = await client.post(f"{path}/diagnosis", json={})
    job = await until(asked.headers["Location"], "state", "succeeded", "failed")
    found = (await client.get(job["result_url"])).json()
    readings = (await client.get(f"{path}/readings")).json()

    assert found["session_id"] == 1
    assert found["robot_serial_number"] == "120-1"
    assert found["measured_at"] == readings[-1]["recorded_at"]


async def test_a_session_that_still_runs_is_diagnosed_with_what_it_has(client, bench, until, worker):
    path = await begun(client, n=60)
    await until(path, "measured", *range(1, 60))
    bench.robot.gate.clear()  # the next motion does not end before the diagnosis has

    asked = await client.post(f"{path}/diagnosis", json={})
    await until(asked.headers["Location"], "state", "succeeded", "failed")
    state = (await client.get(path)).json()["state"]
    bench.robot.gate.set()

    readings = stored_campaign(worker.tasks[0].campaign).calibration
    assert state == "running"
    assert 1 <= len(readings) < 60


async def test_a_session_without_readings_has_nothing_to_diagnose(client):
    refused = await client.post(f"{await planned(client)}/diagnosis", json={})

    assert refused.status_code == 409
    assert "run the session first" in refused.json()["detail"]


async def test_readings_kept_for_validation_are_not_diagnosed(client, until):
    path = await measured(client, until, role="validation")

    refused = await client.post(f"{path}/diagnosis", json={})

    assert refused.status_code == 409
    assert "are for validation and must not be used to identify" in refused.json()["detail"]


async def test_a_diagnosis_asked_twice_with_one_key_runs_once(client, until):
    path, key = await measured(client, until), {"Idempotency-Key": "d-1"}

    first = await client.post(f"{path}/diagnosis", json={}, headers=key)
    await until(first.headers["Location"], "state", "succeeded")
    again = await client.post(f"{path}/diagnosis", json={}, headers=key)

    assert again.headers["Location"] == first.headers["Location"]
    assert len((await client.get("/api/v1/campaigns")).json()) == 1
    assert len((await client.get(DIAGNOSES)).json()) == 1


async def test_robots_with_two_serial_numbers_are_not_compared_with_each_other(settings, worker):
    for serial in ("120-1", "120-2"):
        settings.cell_file.write_text(CELL.replace("120-1", serial))
        bench = Bench()
        bench.robot.serial = serial
        async with served(settings, bench, worker) as (client, until):
            path = await measured(client, until)
            asked = await client.post(f"{path}/diagnosis", json={})
            await until(asked.headers["Location"], "state", "succeeded")
            robot = (await client.get(DIAGNOSES)).json()[0]["robot"]
            mixed = await client.get(f"{DIAGNOSES}/comparison", params={"robot": robot})
            second = {"robot": robot, "serial_number": "120-2"}
            one = await client.get(f"{DIAGNOSES}/comparison", params=second)

    assert mixed.status_code == 409
    assert "serial numbers 120-1, 120-2; specify one of them" in mixed.json()["detail"]
    assert [entry["robot_serial_number"] for entry in one.json()["diagnoses"]] == ["120-2"]
