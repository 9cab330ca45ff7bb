"""Own readings over REST and on their pages: brought, understood, corrected, made a campaign."""

import asyncio
import re
from typing import get_args
from unittest.mock import AsyncMock

import pytest

from tests.helpers.web.pages import Page
from tests.helpers.web.performing import perform_here
from tests.unit.service.exchange.import_wizard.tables import plain
from truepose.analysis.drafts import DraftService
from truepose.analysis.job_queue import queue
from truepose.analysis.job_queue.supervisor import TaskRefusedError
from truepose.analysis.job_queue.uploads import Uploads
from truepose.exchange.import_wizard.dialogue import ROLES
from truepose.exchange.import_wizard.headings import QUANTITIES
from truepose.identification.verdict.conventions import KINDS
from truepose.storage.drafts import MOST_BYTES, DraftFolder
from truepose.web.api.drafts import ChangeKind, MeaningRequest, Role

DRAFTS = "/api/v1/drafts"
BYTES = {"Content-Type": "application/octet-stream"}


async def never(task, told, **_):
    """Leave a job where it is: what jobs answer is tested elsewhere."""
    await asyncio.Event().wait()


@pytest.fixture
def worker():
    return never


@pytest.fixture
async def client(app, client):
    """A client of a service that reads uploads in its own process."""
    context = app.state.context
    desk = DraftService(
        DraftFolder(context.database.file.with_name("drafts")),
        Uploads(perform_here),
        context.campaigns,
        context.job_desk,
    )
    app.state.context = context.__class__(
        **{name: getattr(context, name) for name in context.__slots__} | {"draft_desk": desk}
    )
    return client


async def brought(client, **files):
    path = (await client.post(DRAFTS, json={})).headers["Location"]
    for name, data in files.items():
        name = name.replace("__", ".")
        answer = await client.post(f"{path}/files", params={"name": name}, content=data, headers=BYTES)
        assert answer.status_code == 201, answer.text
    return path


@pytest.fixture
async def path(client):
    """The address of a draft with one table."""
    return await brought(client, mine__csv=plain())


def page_of(path):
    return path.replace("/api/v1/drafts", "/bring")


async def test_a_table_becomes_a_campaign_with_its_diagnosis_under_way(client, app, path):
    asked = (await client.get(f"{path}/understood")).json()
    early = await client.post(f"{path}/campaign", json={})
    said = {"measured_on": "2026-03-03", "measured_by": "Ada", "instrument": "AT960", "certificate": "7"}
    said |= {"robot_serial_number": "120-1", "instrument_serial_number": "T-7"}
    await client.patch(path, json=said)

    made = await client.post(f"{path}/campaign", json={"name": "left arm"})
    again = await client.post(f"{path}/campaign", json={})
    campaign = (await client.get(f"/api/v1/campaigns/{made.json()['campaign_id']}")).json()
    jobs = [(await client.get(f"/api/v1/jobs/{number}")).json()["kind"] for number in made.json()["job_ids"]]

    assert [question["about"] for question in asked["questions"]] == ["day"]
    assert (early.status_code, "When were the readings taken" in early.json()["detail"]) == (409, True)
    assert made.status_code == 201, made.text
    assert again.json() == made.json()
    assert (campaign["name"], campaign["measured_on"], campaign["calibration_points"]) == (
        "left arm",
        "2026-03-03",
        30,
    )
    assert campaign["simulated"] is False
    assert (campaign["robot_serial_number"], campaign["instrument_serial_number"]) == ("120-1", "T-7")
    assert jobs == ["identification", "diagnosis"]
    summary = (await app.state.context.campaigns.get(campaign["id"])).summary
    assert (summary.measured_by, summary.instrument, summary.certificate) == ("Ada", "AT960", "7")


async def test_a_draft_whose_job_is_refused_makes_one_campaign(client, path, monkeypatch):
    await client.patch(path, json={"measured_on": "2026-03-03"})

    with monkeypatch.context() as few:
        few.setattr(queue, "_MOST_WAITING", 1)
        refused = [await client.post(f"{path}/campaign", json={}) for _ in range(2)]
    made = await client.post(f"{path}/campaign", json={})

    assert [answer.status_code for answer in refused] == [503, 503]
    assert made.status_code == 201, made.text
    assert len((await client.get("/api/v1/campaigns")).json()) == 1
    assert [job["id"] for job in (await client.get("/api/v1/jobs")).json()] == made.json()["job_ids"]


@pytest.mark.parametrize(
    ("refusal", "readings"),
    [(TaskRefusedError("mine.csv cannot be read.", "TP-4014"), 1), (TaskRefusedError("It took long."), 2)],
)
async def test_what_was_refused_is_asked_again_only_where_it_may_pass(
    client, path, monkeypatch, refusal, readings
):
    look = AsyncMock(side_effect=refusal)
    monkeypatch.setattr(Uploads, "look", look)

    faults = [(await client.get(f"{path}/understood")).json()["fault"]["sentence"] for _ in range(2)]
    made = await client.post(f"{path}/campaign", json={})

    assert faults == [str(refusal)] * 2
    assert (made.status_code, made.json()["detail"]) == (409, str(refusal))
    assert look.await_count == readings + 1


async def test_a_corrected_line_is_told_with_the_results_and_the_file_stays_as_it_came(client):
    text = plain().decode().splitlines()
    text[14] = "torn"
    path = await brought(client, mine__csv="\n".join(text).encode())
    fault = (await client.get(f"{path}/understood")).json()["fault"]
    await client.patch(path, json={"files": {"mine.csv": {"left_out": [15]}}, "measured_on": "2026-03-03"})

    made = (await client.post(f"{path}/campaign", json={})).json()
    campaign = (await client.get(f"/api/v1/campaigns/{made['campaign_id']}")).json()
    archive = (await client.get(campaign["archive_url"])).content

    assert fault["line"] == 15
    assert campaign["notes"] == ["Line 15 of mine.csv was left out by hand."]
    assert b"brought/mine.csv" in archive


async def test_a_draft_survives_its_service(client, app, path):
    await client.patch(path, json={"measured_on": "2026-03-03"})

    restarted = DraftFolder(app.state.context.database.file.with_name("drafts"))

    (draft,) = restarted.all()
    assert (draft.files[0].name, draft.choices) == ("mine.csv", {"measured_on": "2026-03-03"})


async def test_a_file_brought_anew_takes_the_place_of_the_old_one(client):
    path = await brought(client, mine__csv=b"torn")
    await client.post(f"{path}/files", params={"name": "mine.csv"}, content=plain(), headers=BYTES)

    draft = (await client.get(path)).json()

    assert [(file["name"], file["size_bytes"]) for file in draft["files"]] == [("mine.csv", len(plain()))]


async def test_a_name_with_folders_and_tricks_is_only_a_name(client, app):
    path = await brought(client)
    for name in ("../../etc/passwd", "/abs.csv", "a\\..\\b.csv", "<b>x</b>.csv"):
        await client.post(f"{path}/files", params={"name": name}, content=plain(), headers=BYTES)

    folder = app.state.context.database.file.with_name("drafts")

    inside = {file.name for file in folder.rglob("*") if file.is_file()}
    assert all(re.fullmatch(r"[0-9]+\.file|draft\.json|last", name) for name in inside)


@pytest.mark.parametrize(
    "said",
    [
        {"files": {"mine.csv": {"columns": {"0": {"quantity": "joint", "number": 0, "unit": "deg"}}}}},
        {"files": {"mine.csv": {"columns": {"0": {"quantity": "joint", "number": 1, "unit": "mm"}}}}},
        {"files": {"mine.csv": {"columns": {"x": None}}}},
        {"files": {"mine.csv": {"role": "judge"}}},
        {"measured_on": "yesterday"},
        {"u_mm": 0},
        {"changes": [{"kind": "magic"}]},
        {"robots": "abb-irb-120"},
    ],
)
async def test_what_makes_no_sense_is_refused(client, said):
    path = await brought(client)

    assert (await client.patch(path, json=said)).status_code == 422


async def test_a_draft_is_thrown_away_and_its_number_is_not_used_again(client, path):
    gone = await client.delete(path)
    second = await brought(client)

    assert gone.status_code == 204
    assert (await client.get(path)).status_code == 404
    assert path != second


async def test_more_than_a_draft_holds_is_refused_and_not_kept(client):
    path = await brought(client)

    answer = await client.post(
        f"{path}/files", params={"name": "much.csv"}, content=b"0" * (MOST_BYTES + 1), headers=BYTES
    )

    assert answer.status_code == 413
    assert (await client.get(path)).json()["files"] == []


async def test_the_page_asks_the_one_question_and_shows_every_guess(client, path):
    answer = await client.get(page_of(path))
    page = Page(answer.text)

    assert answer.status_code == 200
    assert "When were the readings taken?" in page.text
    assert "ABB IRB 120" in page.text
    assert sum("data-column" in attributes for _, attributes in page.elements) == 12
    assert sum("data-unit" in attributes for _, attributes in page.elements) == 10


async def test_the_page_shows_the_first_wrong_cell_in_its_place(client):
    text = plain().decode().splitlines()
    text[14] = ",".join([*text[14].split(",")[:8], "<script>alert(1)</script>", *text[14].split(",")[9:]])
    path = await brought(client, mine__csv="\n".join(text).encode())

    answer = await client.get(page_of(path))
    marked = [attributes for tag, attributes in Page(answer.text).elements if attributes.get("aria-invalid")]

    assert "mine.csv, line 15" in answer.text
    assert len(marked) == 1
    assert "<script>alert" not in answer.text


async def test_readings_that_were_brought_are_nowhere_called_simulated(client, path):
    await client.patch(path, json={"measured_on": "2026-03-03"})

    for address in ("/bring", page_of(path)):
        main = (await client.get(address)).text.partition("<main")[2]
        assert "simulated" not in main.replace("The example is a simulated robot", "").lower()


async def test_the_example_says_that_it_is_simulated(client):
    path = (await client.post(DRAFTS, json={"example": True})).headers["Location"]

    understood = (await client.get(f"{path}/understood")).json()
    page = Page((await client.get(page_of(path))).text)

    assert understood["ready"]
    assert understood["simulated"]
    assert "No real robot or instrument was used" in page.text


@pytest.mark.parametrize("address", ["/bring/99", "/bring/nothing", "/bring/-1"])
async def test_a_page_of_nothing_says_so(client, address):
    answer = await client.get(address)

    assert answer.status_code == 404
    assert "Import the readings again" in answer.text


def test_requests_know_every_change_role_and_quantity():
    requests = get_args(get_args(MeaningRequest)[0])
    kinds = {kind for one in requests for kind in get_args(one.model_fields["quantity"].annotation)}

    assert set(get_args(ChangeKind)) == set(KINDS)
    assert set(get_args(Role)) == set(ROLES)
    assert kinds == set(QUANTITIES)
