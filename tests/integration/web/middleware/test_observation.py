"""What is seen of the service from outside: names of requests, lines of the log, figures, health."""

import asyncio
import logging
import re

import pytest

from tests.helpers.web.clients import ENDED, client_of, until
from tests.integration.web.bench import planned, uploaded
from truepose.analysis.job_queue.supervisor import TaskRefusedError
from truepose.correlation import REQUEST
from truepose.storage.errors import StorageUnavailableError
from truepose.web.middleware.request_log import LOGGER

LOOKING = "truepose.health"
CANARY = "SECRET-zQ7-canary"
NAMES = []  # of the requests that led to tasks


@pytest.fixture
def worker():
    async def perform(task, told):
        NAMES.append(REQUEST.get())
        raise TaskRefusedError("Nobody works today.")

    return perform


def figures(text):
    lines = (line for line in text.splitlines() if not line.startswith("#"))
    return {name: float(value) for name, _, value in (line.rpartition(" ") for line in lines)}


@pytest.mark.parametrize("path", ["/health", "/api/v1/sessions/77", "/nowhere", "/static/look.css"])
async def test_every_answer_says_the_name_of_its_request(client, path):
    given = await client.get(path, headers={"X-Request-ID": "tablet-3:17"})
    drawn = [(await client.get(path)).headers["x-request-id"] for _ in range(2)]

    assert given.headers["x-request-id"] == "tablet-3:17"
    assert all(re.fullmatch(r"[0-9a-f]{16}", name) for name in drawn)
    assert drawn[0] != drawn[1]


@pytest.mark.parametrize("name", ["", " ", "-", "a b", "é", "x" * 65, 'x"', "a\tb", "{}"])
async def test_a_name_that_is_not_well_formed_is_replaced(client, name):
    answer = await client.get("/health", headers={"X-Request-ID": name.encode()})

    assert re.fullmatch(r"[0-9a-f]{16}", answer.headers["x-request-id"])


async def test_a_refusal_at_the_door_has_a_name_too(client):
    answer = await client.get("/health", headers={"Host": "elsewhere", "X-Request-ID": "tablet-3"})

    assert (answer.status_code, answer.headers["x-request-id"]) == (421, "tablet-3")


async def test_a_line_tells_the_operation_and_no_secret(client, caplog):
    caplog.set_level(logging.DEBUG, LOGGER)
    secret = {"Authorization": f"Bearer {CANARY}"}

    await client.get(f"/watch/{CANARY}", headers={**secret, "Cookie": f"session={CANARY}"})
    await client.get(f"/api/v1/sessions?after={CANARY}", headers=secret)
    await client.post("/api/v1/sessions", json={"name": CANARY}, headers=secret)

    lines = [record.fields for record in caplog.records if record.name == LOGGER]
    assert [line["operation"] for line in lines][1:] == ["list_sessions", "plan_session"]
    assert CANARY not in caplog.text
    assert CANARY not in str(lines)


async def test_what_a_request_begins_keeps_its_name(client):
    wanted = {"campaign_id": await uploaded(client)}
    await client.post("/api/v1/identifications", json=wanted, headers={"X-Request-ID": "tablet-3"})
    await until(client, "/api/v1/jobs/1", lambda job: job["state"] in ENDED)

    assert NAMES[-1] == "tablet-3"


async def test_figures_count_what_happens_and_what_is_there(client):
    before = figures((await client.get("/metrics")).text)
    await planned(client)
    await client.get("/api/v1/sessions/77")
    answer = await client.get("/metrics")

    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    now = figures(answer.text)
    assert now['truepose_requests_total{operation="get_session",status="404"}'] == 1
    assert now['truepose_request_seconds_count{operation="plan_session"}'] == 1
    assert now["truepose_commit_seconds_count"] > before["truepose_commit_seconds_count"]
    assert now["truepose_event_streams"] == 0
    assert now["truepose_records_refused"] == 0
    assert now["truepose_disk_free_bytes"] > 0
    assert now["truepose_memory_bytes"] > 1e6
    assert 'truepose_device_connected{device="robot"}' in now


async def test_health_keeps_its_keys_and_says_what_was_looked_at(client):
    health = (await client.get("/health")).json()

    assert {"status", "version", "simulated", "schema"} <= health.keys()
    assert [check["name"] for check in health["checks"]] == [
        "database",
        "disk",
        "chain",
        "backup",
        "devices",
        "workers",
        "clock",
        "certificates",
        "log",
    ]
    assert all(check["sentence"].endswith((".", "%.")) for check in health["checks"])
    assert health["verdict"] in {"ok", "warn", "bad"}


async def test_a_browser_is_shown_a_page_in_its_language(client):
    page = await client.get("/health", headers={"Accept": "text/html", "Accept-Language": "fr"})

    assert page.headers["content-type"].startswith("text/html")
    assert "État du service" in page.text
    assert "Place sur le disque" in page.text


async def test_a_database_that_cannot_be_read_is_no_service(app, client, monkeypatch):
    def unreadable(work):
        raise StorageUnavailableError("The disk is gone.")

    monkeypatch.setattr(app.state.context.database, "read", unreadable)
    async with client_of(app) as other:
        answer = await other.get("/health")

        page = await other.get("/health", headers={"Accept": "text/html"})

    assert (answer.status_code, page.status_code) == (503, 503)
    assert "cannot be read" in answer.json()["detail"]
    assert "cannot be read" in page.text


async def test_a_database_that_is_late_is_a_service_until_it_stays_silent(client, monkeypatch):
    async def never(database):
        await asyncio.Event().wait()

    monkeypatch.setattr(f"{LOOKING}.record_counts", never)
    monkeypatch.setattr(f"{LOOKING}._PATIENCE_S", 0.0)
    monkeypatch.setattr(f"{LOOKING}._KEPT_S", 0.0)
    monkeypatch.setattr(f"{LOOKING}._SILENT_S", 0.0)
    late = await client.get("/health")
    silent = await client.get("/health")

    assert (late.status_code, late.json()["verdict"]) == (200, "warn")
    assert "did not respond" in late.text
    assert silent.status_code == 503
