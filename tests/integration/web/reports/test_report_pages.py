"""Reports over the web: listed, searched, shown, printed; the same content is made once."""

import re

import pytest

from tests.helpers.diagnosis.diagnosed_cells import consistent, two_findings
from tests.helpers.domain.builders import make_campaign
from tests.integration.web.bench import session_request
from truepose.analysis.workers.drawing import DrawTask
from truepose.exchange.campaigns.zip_file import write_campaign_zip


class Worker:
    """Draws in this process, and answers everything else with the diagnosis that it was told to give."""

    def __init__(self):
        self.answer = consistent()
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
        worker.answer = answer or consistent()
        archive = write_campaign_zip(make_campaign())
        uploaded = await client.post(
            "/api/v1/campaigns", content=archive, headers={"Content-Type": "application/zip"}
        )
        asked = await client.post("/api/v1/diagnoses", json={"campaign_id": uploaded.json()["id"]})
        job = await until(asked.headers["Location"], "state", "succeeded", "failed")
        return int(job["result_url"].rsplit("/", 1)[1])

    return ask


async def test_there_is_nothing_before_anything_was_made(client):
    page = await client.get("/reports")

    assert page.status_code == 200
    assert "There is no report yet" in page.text


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
    number = await diagnosed(two_findings())

    first = await client.get(f"/reports/diagnosis/{number}")
    again = await client.get(f"/reports/diagnosis/{number}")

    assert first.status_code == 200, first.text
    assert "Diagnosis 1, revision 1" in first.text
    assert first.text == again.text
    assert worker.drawn == 1


async def test_another_language_is_the_same_revision(client, diagnosed):
    number = await diagnosed(two_findings())
    await client.get(f"/reports/diagnosis/{number}")

    french = await client.get(f"/reports/diagnosis/{number}?language=fr")

    assert "Diagnostic 1, révision 1" in french.text


async def test_the_file_and_the_pdf_are_of_the_page(client, diagnosed):
    number = await diagnosed()

    pdf = await client.get(f"/reports/diagnosis/{number}.pdf")
    file = await client.get(f"/reports/diagnosis/{number}.html")

    assert pdf.headers["content-type"] == "application/pdf"
    assert pdf.content.startswith(b"%PDF-")
    assert f'filename="diagnosis-{number}-revision-1.pdf"' in pdf.headers["content-disposition"]
    assert file.text.startswith("<!doctype html>")
    assert "<link" not in file.text


@pytest.mark.parametrize("path", ["/diagnosis/99", "/nothing/1", "/diagnosis/x", "/validation/1?revision=7"])
@pytest.mark.parametrize("form", ["", ".pdf"])
async def test_what_there_is_not_is_said_on_a_page(client, path, form):
    path, _, query = path.partition("?")

    answer = await client.get(f"/reports{path}{form}?{query}")

    assert answer.status_code == 404
    assert "This report cannot be shown" in answer.text


async def test_the_page_that_closes_a_session_shows_which_certificates_did_not_hold(client, until):
    answer = await client.post("/api/v1/sessions", json=session_request(n=3))
    path = answer.headers["Location"]
    await client.post(f"{path}/start")
    await client.post(f"{path}/confirm", json={"person": "Ada"})
    await until(path, "state", "finished")
    page = f"/sessions/{path.rsplit('/', 1)[1]}/closing"

    before = (await client.get(page)).text
    await client.post(
        f"{path}/closing", json={"closed_as": "calibrated", "person": "Ada", "reason": "Checked."}
    )
    after = (await client.get(page)).text

    assert "says no day until which it holds" in before
    assert 'id="close"' in before
    assert 'id="close"' not in after
    assert "although a certificate did not hold" in after
    assert "Checked." in after
