"""A page for each record of a database that a demo run left: its head, its way, and the next step."""

import json

import pytest

from tests.helpers.storage.demo_database import write_demo
from tests.helpers.web.pages import Page, links
from truepose.storage.database import Database


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    file = tmp_path_factory.mktemp("left") / "truepose.sqlite3"
    write_demo(file)
    Database(f"sqlite:///{file}").close()
    return file


@pytest.fixture
def database_url(left, tmp_path):
    copy = tmp_path / "truepose.sqlite3"
    copy.write_bytes(left.read_bytes())
    return f"sqlite:///{copy}"


@pytest.fixture
def worker():
    """Who draws the reports; what a report says is asked where reports are made."""

    async def drawn(task, told):
        return "<main><h1>As its report</h1></main>"

    return drawn


def asked(reply):
    """What the buttons of a page ask of the API, and where they lead."""
    forms = [attributes for tag, attributes in Page(reply.text).elements if tag == "form"]
    return [(json.loads(form["data-asks"]), form["data-leads"]) for form in forms if "data-asks" in form]


_WAY = {"/sessions/1", "/campaigns/1", "/identifications/1", "/models/1", "/validations/1"}


@pytest.mark.parametrize(
    ("path", "shown", "way"),
    [
        ("/identifications/1", "As its report", _WAY),
        ("/validations/1", "As its report", _WAY),
        ("/models/1", "31 parameters describe how this robot differs", _WAY),
        ("/campaigns/1", "calibration points", _WAY | {"/diagnoses/1", "/models/2"}),
        ("/sessions/1", "29 of 29 measured", _WAY | {"/diagnoses/1", "/models/2"}),
        ("/diagnoses/1", "As its report", {"/sessions/1", "/campaigns/1", "/models/2"}),
    ],
)
async def test_a_record_says_what_it_is_and_leads_to_what_it_came_of_and_what_came_of_it(
    client, path, shown, way
):
    reply = await client.get(path, params={"whole": "true"})

    assert reply.status_code == 200
    assert shown in Page(reply.text).text
    assert way <= set(links(reply))
    assert "<h1" in reply.text
    assert "SIMULATED" in reply.text


@pytest.mark.parametrize(
    "path", ["/identifications/1", "/models/1", "/validations/1", "/diagnoses/1", "/models/2"]
)
async def test_each_record_of_what_was_diagnosed_leads_to_the_same_next_step(client, path):
    (step,) = asked(await client.get(path))

    body = {"model_id": 2, "campaign_id": 1}
    assert step == ([{"path": "/api/v1/validations", "body": body, "takes": ""}], "/validations")


@pytest.mark.parametrize("path", ["/models/1", "/models/2"])  # of an identification, of a diagnosis
async def test_a_model_begins_with_the_error_before_and_after(client, path):
    assert "before (nominal)" in Page((await client.get(path)).text).text


async def test_a_diagnosis_leads_to_the_correction_with_its_model(client):
    assert "/corrections?model_id=2" in links(await client.get("/diagnoses/1"))


async def test_a_model_is_taken_along_in_the_formats_that_hold_it_and_the_page_says_why_not_in_others(client):
    reply = await client.get("/models/1?whole=true")
    offered = {href for href in links(reply) if href.startswith("/api/v1/models/1/exports/")}
    answers = {
        form: await client.get(f"/api/v1/models/1/exports/{form}")
        for form in ("urdf", "ros", "dhm", "controller")
    }
    refused = {form for form, answer in answers.items() if answer.status_code == 409}

    assert offered == {f"/api/v1/models/1/exports/{form}" for form in answers if form not in refused}
    assert len(refused) == 1  # else this asks nothing
    assert all(answers[form].json()["detail"] in Page(reply.text).text for form in refused)


async def test_a_job_that_is_done_leads_to_what_it_made(client):
    jobs = (await client.get("/api/v1/jobs")).json()
    made = {job["kind"]: job for job in jobs}["identification"]

    reply = await client.get(f"/jobs/{made['id']}")

    assert "/identifications/1" in links(reply)
    assert 'data-goes="/identifications/1"' in reply.text


_KINDS = (
    "sessions", "campaigns", "identifications", "validations", "models", "diagnoses", "jobs", "corrections",
)  # fmt: skip


@pytest.mark.parametrize("number", ["999", "0", "x", "9" * 40, "٣"])
async def test_an_address_of_nothing_is_answered_by_a_page_that_leads_on(client, number):
    for kind in _KINDS:
        reply = await client.get(f"/{kind}/{number}")

        assert reply.status_code == 404, kind
        assert "Page not found" in Page(reply.text).text, kind
        assert "/work" in links(reply), kind


async def test_the_work_lists_everything_and_finds_by_the_words_of_the_page(client):
    everything = await client.get("/work")
    found = await client.get("/work", params={"q": "calibration", "kind": "sessions"})
    nothing = await client.get("/work", params={"q": "no such thing"})

    assert _WAY | {"/sessions/2", "/diagnoses/1"} <= set(links(everything))
    assert "/sessions/1" in links(found)
    assert "/sessions/2" not in links(found)
    assert "No match for “no such thing”" in Page(nothing.text).text


async def test_the_work_knows_the_robots(client):
    assert "/robots/ABB%20IRB%20120" in links(await client.get("/work?kind=robots"))


@pytest.mark.parametrize("noun", ["robots", "fleet", "campaigns", "readings", "instruments"])
async def test_a_noun_as_an_address_leads_to_the_list_of_it(client, noun):
    answer = await client.get(f"/{noun}", follow_redirects=True)

    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")


async def test_the_cell_says_what_is_connected_and_what_to_do_next(client, bench):
    before = await client.get("/")
    for device in ("tracker", "robot"):
        await client.post(f"/api/v1/devices/{device}/connect")
    after = await client.get("/")

    assert Page(before.text).text.count("not connected") == 2
    assert "not connected" not in Page(after.text).text
    assert "/corrections?model_id=2" in links(after)


async def test_a_device_that_does_not_answer_is_told_with_what_to_do(client, bench):
    bench.tracker.dead = True
    await client.post("/api/v1/devices/tracker/connect")

    text = Page((await client.get("/")).text).text

    assert "tracker does not respond." in text
    assert "Nobody answers at 192.0.2.1:700" in text
    assert "Check the cable and power of the device" in text
