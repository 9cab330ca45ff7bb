"""What configurations promise, over the API and as a page."""

import asyncio

import pytest

from tests.integration.web.bench import session_request
from truepose.planning.prediction import tracker


@pytest.fixture(autouse=True)
def few_to_choose_from(monkeypatch):
    """What is said of a promise is looked at, not how exact it is: fewer candidates, fewer places."""
    monkeypatch.setitem(tracker.promised_session.__kwdefaults__, "n_candidates", 800)
    monkeypatch.setattr(tracker, "VOLUME_CONFIGURATIONS", 40)


async def test_a_cell_says_what_configurations_promise_before_anything_moves(client):
    reply = await client.get("/api/v1/cells/bench/plan?n=25")

    plan = reply.json()
    assert reply.status_code == 200
    assert len(plan["configurations_deg"]) == len(plan["nests"]) == plan["n"] == 25
    assert plan["open"] == []
    assert "legs" not in plan
    assert plan["assumptions"]["discrepancy_mm"] == 0.09  # its devices are said to be real ones
    assert (await client.get("/api/v1/sessions")).json() == []


async def test_there_is_no_promise_of_another_cell_or_of_nothing(client):
    assert (await client.get("/api/v1/cells/other/plan")).status_code == 404
    assert (await client.get("/api/v1/cells/bench/plan?n=0")).status_code == 422
    assert (await client.get("/api/v1/sessions/7/promise")).status_code == 404


async def test_a_session_that_has_measured_nothing_promises_what_its_cell_does(client):
    given = await client.post("/api/v1/sessions", json=session_request())

    promise = (await client.get(f"{given.headers['Location']}/promise?n=20")).json()

    assert promise["measured"] == 0
    assert promise["n"] == 20


class SlowHand:
    """Works nothing out before it may."""

    def __init__(self):
        self.may = asyncio.Event()

    async def __call__(self, task, told):
        await self.may.wait()
        return await asyncio.to_thread(task.perform, lambda *_: None)


class TestAPageThatTakesItsTime:
    @pytest.fixture
    def empty_pictures(self):
        """The curve is looked at here."""

    @pytest.fixture
    def worker(self):
        return SlowHand()

    async def test_its_text_is_there_at_once_and_then_sentences_the_curve_and_every_number(
        self, client, worker
    ):
        early = await client.get("/plan?n=30")
        worker.may.set()
        whole = await client.get("/plan?n=30&whole=true")
        again = await client.get("/plan?n=30&whole=true")

        assert "Expected accuracy after calibration" in early.text
        assert 'aria-busy="true"' in early.text
        assert "/static/drawn.js" in early.text
        assert "Predicted mean error with 30 configurations" in whole.text
        assert "<svg" in whole.text
        assert 'href="/plan?n=50"' in whole.text
        assert "*30" in whole.text
        assert "The star marks the current plan" in whole.text
        # where it is not what is planned
        assert "knee: ten more reduce the error by less than a tenth" in whole.text
        assert again.text == whole.text


async def test_the_page_speaks_french_where_it_is_asked_to(client):
    text = (await client.get("/plan?language=fr&n=30&whole=true")).text

    assert '<html lang="fr">' in text
    assert "Erreur moyenne prévue" in text
    assert 'href="/plan?n=50"' in text
    assert "mean error" not in text


async def test_the_start_page_leads_there(client):
    assert 'href="/plan"' in (await client.get("/")).text


@pytest.mark.usefixtures("text_library")
async def test_what_a_plan_promises_has_a_checklist_before_there_is_a_session(client):
    shown, printed = await client.get("/plan/checklist?n=20"), await client.get("/plan/checklist.pdf?n=20")

    assert shown.text.count('<td><span class="box">') == 20
    assert 'href="/plan/checklist.pdf?n=20"' in shown.text
    assert printed.content.startswith(b"%PDF-")
