"""Whatever goes wrong leaves as a problem document with one sentence."""

import json

import pytest

from tests.integration.web.bench import session_request
from truepose.web.middleware.limits import JSON_LIMIT_BYTES

SESSIONS = "/api/v1/sessions"
JSON = {"Content-Type": "application/json"}


def detail_of(answer, status):
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    problem = answer.json()
    assert problem["status"] == status
    assert problem["detail"].endswith((".", ".)"))
    return problem["detail"]


async def test_a_path_that_is_not_there(client):
    assert "nothing at /api/v1/nothing" in detail_of(await client.get("/api/v1/nothing"), 404)


async def test_a_method_that_is_not_possible_names_all_that_are(client):
    refused = await client.delete(SESSIONS)

    assert "GET, POST" in detail_of(refused, 405)
    assert refused.headers["Allow"] == "GET, POST"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"role": "both"}, "role"),
        ({"name": ""}, "name"),
        ({"settle_s": "4"}, "settle_s"),
        ({"speed_mm_s": 1}, "speed_mm_s"),
        ({"plan": {"method": "given", "stops": []}}, "stops"),
        ({"plan": {"method": "guess"}}, "plan"),
    ],
)
async def test_a_field_that_is_wrong_is_named(client, change, field):
    refused = await client.post(SESSIONS, json=session_request(**change))

    assert field in detail_of(refused, 422)


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999"])
async def test_a_number_that_is_none_is_refused(client, number):
    body = json.dumps(session_request()).replace('"registration_readings": 2', f'"settle_s": {number}')

    refused = await client.post(SESSIONS, content=body, headers=JSON)

    assert "settle_s" in detail_of(refused, 422)


@pytest.mark.parametrize(
    ("content", "media_type", "status", "says"),
    [
        ("{", "application/json", 422, "not JSON"),
        (b"\xe9", "application/json", 400, "The body cannot be read; send JSON in UTF-8."),
        ("name: x", "text/yaml", 415, "text/yaml is not accepted here; send application/json"),
    ],
)
async def test_a_body_that_cannot_be_read_is_refused(client, content, media_type, status, says):
    refused = await client.post(SESSIONS, content=content, headers={"Content-Type": media_type})

    assert says in detail_of(refused, status)


async def test_what_cannot_be_seen_is_refused_in_words(client):
    unseen = await client.post(SESSIONS, json=session_request(name=" \u00a0"))
    blank = await client.post(SESSIONS, json=session_request(), headers={"Idempotency-Key": "left arm"})

    assert detail_of(unseen, 422) == "name: no visible character; enter at least one."
    assert "without spaces" in detail_of(blank, 422)


@pytest.mark.parametrize("declared", [True, False])
async def test_a_body_that_is_too_large(client, declared):
    async def chunks():
        for _ in range(JSON_LIMIT_BYTES // 2**20 + 1):
            yield b" " * 2**20

    content = b" " * (JSON_LIMIT_BYTES + 1) if declared else chunks()

    refused = await client.post(SESSIONS, content=content, headers=JSON)

    assert "larger than 8 MB" in detail_of(refused, 413)


@pytest.mark.parametrize("number", ["0", "-1", "abc", "9999999999999999999999"])
async def test_a_number_that_no_record_can_have(client, number):
    assert "id" in detail_of(await client.get(f"{SESSIONS}/{number}"), 422)


@pytest.mark.parametrize(
    "resource", ["sessions", "readings", "jobs", "identifications", "validations", "models", "campaigns"]
)
async def test_a_record_that_is_not_there_is_named(client, resource):
    refused = await client.get(f"/api/v1/{resource}/7")

    assert detail_of(refused, 404) == f"There is no {resource.rstrip('s')} 7."


async def test_a_problem_says_what_it_means_for_the_data_and_what_to_do(client):
    problem = (await client.get("/api/v1/sessions/7")).json()

    assert (problem["code"], problem["code_url"]) == ("TP-1020", "/errors/TP-1020")
    assert problem["meaning"] == "Nothing was stored or changed."
    assert problem["action"].startswith("Look up the number")


@pytest.mark.parametrize(
    ("path", "code"),
    [("/nothing", "TP-1004"), (f"{SESSIONS}?limt=3", "TP-1002"), (f"{SESSIONS}?limit=x", "TP-1001")],
)
async def test_what_is_no_error_of_a_class_has_a_code_too(client, path, code):
    assert (await client.get(path)).json()["code"] == code


@pytest.mark.parametrize(
    ("language", "says"), [("en", "What it means for your data"), ("fr", "pour vos données")]
)
async def test_a_code_has_a_page_in_every_language(client, language, says):
    page = await client.get(f"/errors/tp-1020?language={language}")
    listed = await client.get(f"/errors?language={language}")

    assert (page.status_code, listed.status_code) == (200, 200)
    assert says in page.text
    assert 'href="/errors/TP-9001"' in listed.text


async def test_a_code_that_there_is_not_leads_to_those_that_there_are(client):
    page = await client.get("/errors/TP-0000")

    assert page.status_code == 404
    assert 'href="/errors"' in page.text


@pytest.mark.parametrize(
    ("method", "path", "sent", "status", "said"),
    [
        ("GET", "/api/v1/nothing", {}, 404, "Unter /api/v1/nothing gibt es nichts"),
        ("DELETE", SESSIONS, {}, 405, "DELETE ist unter /api/v1/sessions nicht möglich; GET, POST ist es."),
        ("GET", f"{SESSIONS}?limt=3", {}, 422, "query.limt: hier unbekannt; war limit gemeint."),
        ("POST", SESSIONS, {"json": {"name": " "}}, 422, "weitere dieser Art.)"),
        ("POST", SESSIONS, {"content": "a", "headers": {"Content-Type": "a/b"}}, 415, "Der Inhalt ist a/b"),
        ("POST", SESSIONS, {"content": "{", "headers": JSON}, 422, "Der Inhalt ist kein JSON"),
        ("POST", SESSIONS, {"content": r'"\ud83d"', "headers": JSON}, 422, r"(wie \ud83d allein)"),
        ("GET", SESSIONS, {"headers": {"Host": "other"}}, 421, "antwortet nicht als other"),
        ("GET", SESSIONS, {"headers": {"Origin": "http://a.b"}}, 403, "von einer Seite von http://a.b;"),
    ],
)
async def test_a_refusal_is_in_the_words_of_whoever_asks(client, method, path, sent, status, said):
    client.headers["Accept-Language"] = "de"

    assert said in detail_of(await client.request(method, path, **sent), status)


async def test_a_record_that_is_not_there_is_named_in_the_words_of_whoever_asks(client):
    asked = await client.get(f"{SESSIONS}/7", headers={"Accept-Language": "de"})
    page = await client.get("/reports/session/7", headers={"Accept": "text/html", "Accept-Language": "fr"})

    assert detail_of(asked, 404) == "Nicht vorhanden: Sitzung 7."
    assert "Introuvable\u00a0: session 7." in page.text
