"""What stands behind the question mark: pages of lists, and names that no operation knows."""

import pytest
from starlette.requests import Request

from tests.integration.web.bench import session_request
from truepose.storage.records import Page
from truepose.web.resources import request_key

SESSIONS = "/api/v1/sessions"


async def refusal(client, path):
    refused = await client.get(path)
    assert refused.status_code == 422
    return refused.json()["detail"]


@pytest.mark.parametrize(
    ("path", "says"),
    [
        (f"{SESSIONS}?limt=3", "query.limt: unknown parameter; you may mean limit."),
        ("/api/v1/jobs?state=failed", "valid parameters are after, limit."),
        ("/api/v1/devices/tracker?limit=3", "no parameters are accepted here."),
    ],
    ids=["misspelt", "like no other", "none is taken"],
)
async def test_an_unknown_parameter_is_refused_with_what_may_have_been_meant(client, path, says):
    assert (await refusal(client, path)).endswith(says)


@pytest.mark.parametrize(
    "path", ["/api/v1/robots/a%00b", "/robots/a%00", "/api/v1/audit?search=%00", "/audit?q=a%00b"]
)
async def test_an_address_with_a_zero_byte_is_refused_before_a_database_sees_it(client, path):
    assert "zero byte (%00)" in await refusal(client, path)


@pytest.mark.parametrize("given", ["", "?after=0&limit=2", "?limit=2"])
async def test_parameters_that_are_known_are_taken(client, given):
    assert (await client.get(f"{SESSIONS}{given}")).status_code == 200


async def test_a_page_says_how_many_there_are_and_where_the_next_one_is(client):
    for name in ("first", "second", "third"):
        await client.post(SESSIONS, json=session_request(name=name))

    page = await client.get(f"{SESSIONS}?limit=2")
    rest = await client.get(page.links["next"]["url"])

    assert [one["name"] for one in page.json() + rest.json()] == ["first", "second", "third"]
    assert page.headers["Total-Count"] == rest.headers["Total-Count"] == "3"
    assert "next" not in rest.links


@pytest.mark.parametrize("path", ["/api/v1/devices", "/api/v1/robots"])
async def test_what_has_no_numbers_is_counted_from_the_beginning(client, path):
    whole = await client.get(path)
    first = await client.get(f"{path}?limit=1")
    rest = await client.get(first.links["next"]["url"].replace("limit=1", "limit=500"))
    beyond = await client.get(f"{path}?after=1000")

    assert first.json() + rest.json() == whole.json()
    assert {reply.headers["Total-Count"] for reply in (whole, first, rest)} == {str(len(whole.json()))}
    assert (whole.links, rest.links, beyond.links, beyond.json()) == ({}, {}, {}, [])


async def test_a_list_of_nothing_has_no_next_page(client):
    made = (await client.post(SESSIONS, json=session_request())).json()

    page = await client.get(f"/api/v1/readings?session_id={made['id']}&kind=point&superseded=false&limit=1")

    assert (page.json(), page.headers["Total-Count"], page.links) == ([], "0", {})


async def test_a_page_is_bounded_whatever_is_asked_for(client, app, monkeypatch):
    asked = []
    sessions = app.state.context.sessions
    page_of = type(sessions).page

    async def listening(self, page):
        asked.append(page)
        return await page_of(self, page)

    monkeypatch.setattr(type(sessions), "page", listening)
    await client.get(f"{SESSIONS}?limit=1000")

    assert asked == [Page(0, 500)]


@pytest.mark.parametrize(("other", "is_same"), [(b"limit=3", True), (b"limit=4", False), (b"", False)])
def test_a_key_that_comes_back_with_another_query_is_of_another_request(other, is_same):
    def fingerprint(query):
        asked = {"type": "http", "method": "POST", "path": SESSIONS, "query_string": query, "headers": []}
        return request_key(Request(asked), "key-1", b"{}").fingerprint

    assert (fingerprint(other) == fingerprint(b"limit=3")) is is_same
