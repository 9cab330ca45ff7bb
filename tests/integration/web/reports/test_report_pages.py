"""Reports over the web: listed, searched, shown, printed; the same content is made once."""

import re
from datetime import date

import pytest

from tests.helpers.diagnosis.diagnosed_cells import nothing_fitted, two_findings
from tests.helpers.domain.builders import make_identification
from tests.helpers.web.pages import Page
from tests.integration.web.bench import measured, number_of, planned, uploaded
from tests.integration.web.calibration.stored_models import store_model
from truepose.analysis.job_queue.tasks import DrawTask


class Worker:
    """Draws in this process, and answers everything else with the diagnosis that it was told to give."""

    def __init__(self):
        self.answer = nothing_fitted()  # has no pictures, and is quick to draw
        self.drawn = 0

    async def __call__(self, task, told):
        if not isinstance(task, DrawTask):
            return self.answer
        self.drawn += 1
        return task.perform(lambda *_: None)


@pytest.fixture
def worker():
    return Worker()


@pytest.fixture
def diagnosed(client, until, worker):
    """Diagnose an uploaded campaign and return the number of the diagnosis."""

    async def ask(answer=None):
        worker.answer = answer or nothing_fitted()
        asked = await client.post("/api/v1/diagnoses", json={"campaign_id": await uploaded(client)})
        job = await until(asked.headers["Location"], "state", "succeeded", "failed")
        return number_of(job["result_url"])

    return ask


async def test_an_identification_and_a_diagnosis_state_what_their_campaign_states(client, until, worker):
    campaign_id = await uploaded(client, measured_on=date(2026, 3, 3), robot_serial_number="120-5")

    for kind, resource, answer in (
        ("identification", "identifications", make_identification(model=None)),
        ("diagnosis", "diagnoses", nothing_fitted()),
    ):
        worker.answer = answer
        asked = await client.post(f"/api/v1/{resource}", json={"campaign_id": campaign_id})
        await until(asked.headers["Location"], "state", "succeeded")
        page = Page((await client.get(f"/reports/{kind}/1")).text).text
        assert "Measured 2026-03-03" in page
        assert "serial number 120-5" in page


async def test_there_is_nothing_before_anything_was_made(client):
    page = await client.get("/reports")

    assert page.status_code == 200
    assert "No reports yet" in page.text


async def test_reports_are_found_by_robot_words_and_month(client, diagnosed):
    await diagnosed(), await diagnosed(two_findings())
    everything = await client.get("/reports")
    month = re.search(r"<td>(\d{4}-\d{2})-\d{2}</td>", everything.text)[1]

    assert everything.text.count('href="/reports/diagnosis/') == 4  # two, each with its PDF
    for query, rows in (
        (f"month={month}", 2),
        ("month=1999-01", 0),
        ("q=nobody%27s+robot", 0),
        ("month=x", 2),
    ):
        text = (await client.get(f"/reports?{query}")).text
        assert text.count('.pdf"') == rows, query
    first_words = two_findings().message.split()[:3]
    assert (await client.get("/reports", params={"q": " ".join(first_words)})).text.count('.pdf"') == 1


async def test_a_report_is_made_once_for_the_same_content(client, diagnosed, worker):
    number = await diagnosed()

    first = await client.get(f"/reports/diagnosis/{number}")
    again = await client.get(f"/reports/diagnosis/{number}")

    assert first.status_code == 200, first.text
    assert "Diagnosis 1, revision 1" in first.text
    assert first.text == again.text
    assert worker.drawn == 1


async def test_another_language_is_the_same_revision(client, diagnosed):
    number = await diagnosed()
    await client.get(f"/reports/diagnosis/{number}")

    french = await client.get(f"/reports/diagnosis/{number}?language=fr")

    assert "Diagnostic 1, révision 1" in french.text


@pytest.mark.usefixtures("text_library")
async def test_the_file_and_the_pdf_are_of_the_page(client, diagnosed):
    number = await diagnosed()

    pdf = await client.get(f"/reports/diagnosis/{number}.pdf")
    file = await client.get(f"/reports/diagnosis/{number}.html")

    assert pdf.headers["content-type"] == "application/pdf"
    assert pdf.content.startswith(b"%PDF-")
    assert f'filename="diagnosis-{number}-revision-1.pdf"' in pdf.headers["content-disposition"]
    assert file.text.startswith("<!doctype html>")
    assert "<link" not in file.text


@pytest.mark.usefixtures("text_library")
async def test_a_pdf_is_printed_once_and_sent_once(client, diagnosed, worker):
    address = f"/reports/diagnosis/{await diagnosed()}.pdf"

    first = await client.get(address)
    again = await client.get(address)
    known = await client.get(address, headers={"If-None-Match": first.headers["ETag"]})

    assert worker.drawn == 2  # the report, and its PDF
    assert again.content == first.content
    assert not first.headers["ETag"].startswith("W/")
    assert (known.status_code, known.content) == (304, b"")


@pytest.mark.parametrize("path", ["/diagnosis/99", "/nothing/1", "/diagnosis/x", "/validation/1?revision=7"])
@pytest.mark.parametrize("form", ["", ".pdf"])
async def test_what_there_is_not_is_said_on_a_page(client, path, form):
    path, _, query = path.partition("?")

    answer = await client.get(f"/reports{path}{form}?{query}")

    assert answer.status_code == 404
    assert "This report cannot be shown" in answer.text


async def test_a_session_passes_or_not_on_its_first_page_and_closing_it_is_a_revision(app, client, until):
    await store_model(app.state.context)
    number = number_of(await measured(client, until, role="validation"))

    judged = (await client.get(f"/reports/session/{number}", params={"limit_mm": 0.2})).text
    await client.post(
        f"/api/v1/sessions/{number}/closing",
        json={"closed_as": "calibrated", "person": "Ada", "reason": "Checked on the bar."},
    )
    closed = (await client.get(f"/reports/session/{number}", params={"limit_mm": 0.2})).text
    older = (await client.get(f"/reports/session/{number}", params={"revision": 1})).text

    assert "FAILED" in judged
    assert "guard band to ISO 14253-1" in judged
    assert f"{number}, revision 1" in judged
    assert "Not closed yet" in judged
    assert "revision 2" in closed
    assert "Reason given: Checked on the bar." in closed
    assert "Not closed yet" in older
    assert "Confirmations: 1. 1 of them started an arm motion." in closed
    assert closed.index("Confirmations") < closed.index("Head of the hash chain of all records")


async def test_a_session_for_an_identification_has_no_report_of_its_own(client, until):
    number = number_of(await measured(client, until))

    answer = await client.get(f"/reports/session/{number}")

    assert answer.status_code == 409
    assert "see the report of the identification instead" in answer.text


async def test_the_page_that_closes_a_session_shows_which_certificates_did_not_hold(client, until):
    number = number_of(await measured(client, until))
    page, path = f"/sessions/{number}/closing", f"/api/v1/sessions/{number}"

    before = (await client.get(page)).text
    await client.post(
        f"{path}/closing", json={"closed_as": "calibrated", "person": "Ada", "reason": "Checked."}
    )
    after = (await client.get(page)).text

    assert "states no expiry date" in before
    assert 'id="close"' in before
    assert 'id="close"' not in after
    assert "although a certificate was not valid" in after
    assert "Checked." in after


@pytest.mark.usefixtures("text_library")
async def test_a_planned_session_has_a_checklist_to_print(client):
    page = f"/sessions/{number_of(await planned(client))}/checklist"

    shown, printed = await client.get(page), await client.get(f"{page}.pdf")

    assert shown.status_code == 200
    assert shown.text.count('<td><span class="box">') == 3
    assert printed.content.startswith(b"%PDF-")
    assert (await client.get("/sessions/99/checklist")).status_code == 404


async def test_a_report_in_inches_is_the_same_revision_and_the_one_in_mm_stays(client, diagnosed, worker):
    number = await diagnosed(two_findings())
    address = f"/reports/diagnosis/{number}"

    metric = await client.get(f"{address}.html")
    inch = await client.get(f"{address}.html?units=inch")
    kept = await client.get(f"{address}.html", headers={"Cookie": "units=inch-deg-c"})
    again = await client.get(f"{address}.html?units=mm")

    assert "mm, deg, °C" in metric.text and "in, deg, °C" in inch.text
    assert kept.text == inch.text and again.text == metric.text
    assert worker.drawn == 2
    assert metric.headers["Content-Disposition"] == inch.headers["Content-Disposition"]
