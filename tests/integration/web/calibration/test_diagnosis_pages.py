"""Diagnoses as pages: what a person at the cell reads."""

import re
from dataclasses import replace
from datetime import date

import pytest

from tests.helpers.diagnosis.diagnosed_cells import ENDINGS, consistent, nothing_fitted, two_findings
from tests.helpers.domain.builders import make_campaign
from tests.integration.web.bench import number_of, uploaded
from truepose.analysis.job_queue.tasks import DrawTask
from truepose.domain.cell import SimulatedCell
from truepose.messages.catalogue import catalogue
from truepose.messages.message import message
from truepose.web.pages.diagnosis import measured_words

HOSTILE = "<script>alert('x')</script>"


class Diagnostician:
    """Answers every request with the diagnosis that it was told to give, and draws its report itself."""

    def __init__(self):
        self.answer = consistent()

    async def __call__(self, task, told):
        return task.perform(lambda *_: None) if isinstance(task, DrawTask) else self.answer


@pytest.fixture
def worker():
    return Diagnostician()


@pytest.fixture
def diagnosed(client, until, worker):
    """Diagnose an uploaded campaign and return the number of the diagnosis."""

    async def ask(answer, measured_on=None, measured_on_in_file=None, **campaign):
        worker.answer = answer
        number = await uploaded(client, measured_on=measured_on_in_file, **campaign)
        asked = await client.post(
            "/api/v1/diagnoses", json={"campaign_id": number, "measured_on": measured_on}
        )
        job = await until(asked.headers["Location"], "state", "succeeded", "failed")
        return number_of(job["result_url"])

    return ask


@pytest.mark.parametrize("ending", ENDINGS)
async def test_a_stored_diagnosis_is_shown_as_its_report(client, diagnosed, ending):
    answer = ENDINGS[ending]()
    number = await diagnosed(answer)

    reply = await client.get(f"/diagnoses/{number}?whole=true")

    assert reply.status_code == 200
    assert reply.headers["content-type"] == "text/html; charset=utf-8"
    assert f'class="message">{answer.message.replace(chr(39), "&#39;")}</p>' in reply.text
    assert ("No result." in reply.text) == (answer.model is None)  # the model is stored apart
    assert all(finding.sentence in reply.text.replace("&#39;", "'") for finding in answer.findings)


async def test_the_list_shows_the_first_lines_newest_first(client, diagnosed):
    older, newer = await diagnosed(consistent()), await diagnosed(two_findings())

    text = (await client.get("/diagnoses")).text

    assert 0 < text.index(f'href="/diagnoses/{newer}"') < text.index(f'href="/diagnoses/{older}"')
    assert "Consistent" in text
    assert two_findings().message in text


def spoken():
    """A diagnosis as the numerics make it: what it says can be said in every language."""
    return replace(consistent(), message=message("message.consistent"), noise=None)


@pytest.mark.parametrize(
    ("address", "accepted", "language", "told"),
    [
        ("", "", "en", "No further error source found"),
        ("", "fr-CH, en;q=0.8", "fr", "Le modèle actuel explique les données"),
        ("", "en, fr;q=0.2", "en", "No further error source found"),
        ("?language=fr", "en", "fr", "Le modèle actuel explique les données"),
        ("?language=xx", "", "en", "No further error source found"),
    ],
)
async def test_a_stored_diagnosis_is_shown_in_the_language_asked_for(
    client, diagnosed, address, accepted, language, told
):
    number = await diagnosed(spoken())

    for path in ("/diagnoses", f"/diagnoses/{number}"):
        whole = f"{path}{address or '?'}&whole=true"
        reply = await client.get(whole, headers={"Accept-Language": accepted})
        assert told in reply.text
        assert f'<html lang="{language}">' in reply.text
        assert reply.headers["Content-Language"] == language
        assert "Accept-Language" in reply.headers["Vary"]


async def test_the_language_that_was_asked_for_stays_until_another_is(client):
    french = {"Accept-Language": "fr"}

    preferred = (await client.get("/diagnoses", headers=french)).text
    await client.get("/diagnoses?language=en", headers=french)
    kept = (await client.get("/diagnoses", headers=french)).text
    await client.get("/diagnoses?language=xx", headers=french)
    unknown = (await client.get("/diagnoses", headers=french)).text

    assert '<html lang="fr">' in preferred
    assert '<html lang="en">' in kept
    assert '<html lang="en">' in unknown
    assert '<a href="?language=fr" hreflang="fr" lang="fr">Français</a>' in kept


async def test_the_look_that_was_asked_for_stays_and_the_system_chooses_again(client):
    plain = (await client.get("/diagnoses")).text
    await client.get("/diagnoses?look=dark")
    kept = (await client.get("/sessions")).text
    await client.get("/diagnoses?look=unknown")
    unknown = (await client.get("/sessions")).text
    await client.get("/diagnoses?look=system")
    system = (await client.get("/sessions")).text

    assert "data-look" not in plain
    assert '<html lang="en" data-look="dark">' in kept
    assert '<html lang="en" data-look="dark">' in unknown
    assert "data-look" not in system


async def test_documents_are_in_english_whoever_asks_and_jobs_in_the_language_of_whoever_does(
    client, diagnosed
):
    number = await diagnosed(spoken())
    french = {"Accept-Language": "fr"}

    told = (await client.get(f"/api/v1/diagnoses/{number}", headers=french)).json()
    job = (await client.get(f"/api/v1/jobs/{told['job_id']}", headers=french)).json()

    assert told["document"]["message"].startswith("No further error source found")
    assert job["message"] == catalogue("fr").spoken(spoken().message)


async def test_the_list_does_not_call_unexplained_what_was_not_answered(client, diagnosed):
    await diagnosed(nothing_fitted())

    text = (await client.get("/diagnoses")).text

    assert ("No result" in text, "Unexplained" in text) == (True, False)


async def test_without_any_the_list_says_how_to_ask_for_one(client):
    text = (await client.get("/diagnoses")).text

    assert "No diagnoses yet." in text
    assert "/api/v1/diagnoses" in text


async def test_a_simulated_campaign_says_so_on_a_service_that_is_not(client, diagnosed):
    number = await diagnosed(consistent(), simulated=True)

    text = (await client.get(f"/diagnoses/{number}?whole=true")).text

    assert 0 < text.index("SIMULATED.") < text.index('class="message"')
    assert "SIMULATED</strong>" in (await client.get("/diagnoses")).text


async def test_uploaded_readings_are_not_called_simulated_by_a_service_whose_cell_is(app, client, diagnosed):
    number = await diagnosed(consistent())
    here = app.state.context
    app.state.context = replace(here, cell=replace(here.cell, simulated=SimulatedCell("irb120-tilted", 0)))

    text = (await client.get(f"/diagnoses/{number}?whole=true")).text
    listed = (await client.get("/diagnoses")).text

    assert "SIMULATED" not in text + listed
    assert "simulated" not in text.partition("<main")[0].partition("</header>")[2]
    assert "This service runs a simulated cell." in listed


async def test_text_of_others_stays_text(client, diagnosed):
    number = await diagnosed(replace(consistent(), message=HOSTILE, robot=HOSTILE))

    texts = [(await client.get(path)).text for path in ("/diagnoses", f"/diagnoses/{number}?whole=true")]

    assert not any("<script>alert" in text for text in texts)


async def test_pages_are_no_part_of_the_api(client):
    paths = (await client.get("/openapi.json")).json()["paths"]

    assert not any(path.startswith("/diagnoses") for path in paths)


async def test_a_day_is_shown_as_a_day_and_a_time_to_the_minute(client, diagnosed):
    number = await diagnosed(consistent(), "2026-03-03")

    assert "measured 2026-03-03 \N{MIDDLE DOT}" in (await client.get(f"/diagnoses/{number}?whole=true")).text
    assert measured_words("2026-03-03T09:12:33.125+00:00") == "measured 2026-03-03 09:12 UTC"


async def test_readings_of_which_nobody_said_when_are_not_of_the_day_of_their_upload(client, diagnosed):
    number = await diagnosed(consistent())

    texts = [(await client.get(path)).text for path in ("/diagnoses", f"/diagnoses/{number}?whole=true")]

    assert all("date not stated" in text for text in texts)
    assert not any("measured 20" in text for text in texts)


async def test_a_day_in_the_description_of_an_upload_is_the_day_of_its_readings(client, diagnosed):
    number = await diagnosed(consistent(), measured_on_in_file=date(2025, 11, 3))

    assert "measured 2025-11-03" in (await client.get(f"/diagnoses/{number}?whole=true")).text


async def test_an_uploaded_campaign_has_no_session_to_measure_more_in(client, diagnosed):
    number = await diagnosed(two_findings())

    text = (await client.get(f"/diagnoses/{number}?whole=true")).text

    assert "Measure these next" not in text
    assert "measure-next.js" not in text


async def test_the_page_leads_to_its_document_and_to_the_robot_over_time(client, diagnosed):
    number = await diagnosed(replace(two_findings(), robot=make_campaign().robot.name))

    links = re.findall(
        r'href="(/api/v1/diagnoses[^"]*)"', (await client.get(f"/diagnoses/{number}?whole=true")).text
    )

    assert len(links) == 2
    assert [(await client.get(link.replace("&amp;", "&"))).status_code for link in links] == [200, 200]
