"""Readings that were set aside stay so when a session is diagnosed again, unless a person says otherwise."""

import json
import re
from html import unescape

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.domain.builders import make_identification
from tests.integration.web.bench import measured, uploaded
from tests.integration.web.diagnosing import Diagnostician
from truepose.analysis.job_queue.tasks import DrawTask
from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.storage.records import JobKind

ASIDE = ReadingsSetAside((ReadingName(2, 1),), "a cable lay there", "Ada Byron", (1,), ("a cable lay there",))
SAID = "1 reading set aside by Ada Byron: a cable lay there."
KEEPING = {"keep_set_aside": True}


class Draughtsman(Diagnostician):
    """Draws what is to be drawn, and diagnoses whatever it is told to."""

    async def __call__(self, task, told):
        return (
            task.perform(lambda *_: None)
            if isinstance(task, DrawTask)
            else await super().__call__(task, told)
        )


@pytest.fixture
def worker():
    return Draughtsman()


@pytest.fixture
def made(client, until, worker):
    """Ask for a diagnosis, and return what it was made without."""

    async def ask(path, body):
        asked = await client.post(path, json=body)
        assert asked.status_code == 202, asked.text
        job = await until(asked.headers["Location"], "state", "succeeded", "failed")
        assert job["state"] == "succeeded", job["message"]
        return worker.tasks[-1].set_aside

    return ask


@pytest.fixture
async def session(client, until):
    """A session of ten configurations that has ended."""
    return await measured(client, until, n=10)


@pytest.fixture
async def campaign_id(client, session):
    made_of = await client.post(f"{session}/campaign", json={"name": "left arm"})
    return made_of.json()["id"]


@pytest.fixture
def identified(app):
    """Store an identification of a campaign that left readings out, or none."""
    here = app.state.context

    async def keep(campaign_id, aside):
        job = await here.jobs.add(JobKind.IDENTIFICATION, {})
        await here.results.keep_identification(job, campaign_id, make_identification(set_aside=aside))

    return keep


async def test_nothing_is_set_aside_where_nothing_was(made, session):
    assert await made(f"{session}/diagnosis", {}) is None
    assert await made(f"{session}/diagnosis", KEEPING) is None


async def test_what_a_diagnosis_of_the_session_left_out_stays_out(made, session, worker):
    worker.found = [make_diagnosis(set_aside=ASIDE)]
    await made(f"{session}/diagnosis", {})

    assert await made(f"{session}/diagnosis", {}) == ASIDE


@pytest.mark.parametrize("by", ["session", "campaign"])
async def test_what_an_identification_of_the_session_left_out_stays_out(
    made, session, campaign_id, identified, by
):
    await identified(campaign_id, ASIDE)
    asked = {
        "session": (f"{session}/diagnosis", {}),
        "campaign": ("/api/v1/diagnoses", {"campaign_id": campaign_id, **KEEPING}),
    }

    assert await made(*asked[by]) == ASIDE


async def test_a_person_may_use_all_readings(made, session, campaign_id, identified):
    await identified(campaign_id, ASIDE)

    assert await made(f"{session}/diagnosis", {"keep_set_aside": False}) is None
    assert await made("/api/v1/diagnoses", {"campaign_id": campaign_id}) is None


async def test_the_newest_result_counts_of_whichever_kind(made, session, campaign_id, identified, worker):
    worker.found = [make_diagnosis(set_aside=ASIDE)]
    await made(f"{session}/diagnosis", {})
    await identified(campaign_id, None)

    assert await made(f"{session}/diagnosis", {}) is None


async def test_an_upload_has_results_of_its_own_alone(client, made, identified):
    first, second = [await uploaded(client) for _ in range(2)]
    await identified(first, None)
    await identified(second, ASIDE)

    assert await made("/api/v1/diagnoses", {"campaign_id": first, **KEEPING}) is None


async def test_what_is_named_comes_before_what_was_set_aside(client, made, session, campaign_id, identified):
    await identified(campaign_id, ASIDE)
    other = {"person": "Ada Byron", "reason": "it slipped", "readings": [{"config": 5, "nest": 1}]}

    found = await made("/api/v1/diagnoses", {"campaign_id": campaign_id, "set_aside": other, **KEEPING})

    assert found.readings == (ReadingName(5, 1),)


def bodies(text):
    return [json.loads(unescape(body)) for body in re.findall(r'data-again="(\{[^"]*)"', text)]


async def test_the_page_says_what_a_new_diagnosis_leaves_out_and_offers_all_readings(
    client, made, session, worker
):
    worker.found = [make_diagnosis(set_aside=ASIDE)]
    await made(f"{session}/diagnosis", {})

    act = (await client.get("/diagnoses/1")).text.partition('class="act')[2]

    assert f"{SAID} A new diagnosis leaves them out as well." in act
    assert "Diagnose with all readings" in act
    keeping, whole = bodies(act)
    assert await made(f"{session}/diagnosis", keeping) == ASIDE
    assert await made(f"{session}/diagnosis", whole) is None


async def test_the_page_of_a_diagnosis_of_all_readings_says_nothing_of_it(client, made, session):
    await made(f"{session}/diagnosis", {})

    text = (await client.get("/diagnoses/1")).text

    assert len(bodies(text)) == 1
    assert "leaves them out" not in text
