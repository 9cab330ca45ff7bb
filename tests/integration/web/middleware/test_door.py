"""Nobody's page but ours asks this service anything: every route, every method, every way to try."""

import contextlib
from itertools import cycle, islice

import pytest
from fastapi.responses import HTMLResponse

from tests.helpers.web.routes import METHODS, addresses_of, asked, paths_answering, paths_of
from truepose.web.application import create_application
from truepose.web.middleware.hosts import AllowedHosts
from truepose.web.middleware.security import PAGES
from truepose.web.pages.work import NOUNS

APP = create_application("test", contextlib.nullcontext, AllowedHosts(["cell3.shop", "https://proxy.shop"]))
TAKING_FILES = {"/api/v1/campaigns", "/api/v1/models/1/corrections"}  # as forms bring them
ADDRESSES = addresses_of(APP)
HERE = ("host", "localhost:8000")
READING = {"GET", "HEAD", "OPTIONS"}
CHANGING = [method for method in METHODS if method not in READING]

HOSTS = [
    "evil.example",
    "evil.example:8000",
    "localhost.evil.example",
    "localhost.",
    "127.0.0.1.evil.example",
    "127.0.0.2",
    "127.1",
    "0.0.0.0:8000",
    "0",
    "[::]:8000",
    "[::ffff:127.0.0.1]",
    "2130706433",
    "0x7f.1",
    "user@localhost",
    "localhost@evil.example",
    "localhost:8000@evil.example",
    "localhost/",
    "localhost:port",
    "localhost:99999",
    "localhost:",
    "local host",
    "localhost,evil.example",
    "localhost#",
    "[::1",
    "[localhost]",
    "[]",
    "",
    "*",
    "lo\xe7alhost",
]
FOREIGN_ORIGINS = [
    "null",
    "http://evil.example",
    "http://localhost",
    "http://localhost:8001",
    "https://localhost:8000",
    "http://127.0.0.1:8000",
    "http://cell3.shop:8000",
    "http://localhost:8000.evil.example",
    "http://localhost:8000/",
    "http://user@localhost:8000",
    "file://",
    "localhost:8000",
    "",
]
FOREIGN_FETCHES = [
    *[[("sec-fetch-site", site)] for site in ("cross-site", "same-site", "other", "same-origin, cross-site")],
    [("sec-fetch-site", "same-origin"), ("sec-fetch-site", "cross-site")],
    [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "no-cors"), ("sec-fetch-dest", "image")],
    [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "iframe")],
    *[
        [("sec-fetch-site", site), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", frame)]
        for site in ("same-origin", "none")
        for frame in ("iframe", "frame", "embed", "object", "fencedframe")
    ],
]
UNPROVEN = [
    [("sec-fetch-site", "none")],
    [("sec-fetch-mode", "navigate")],
    [("referer", "http://evil.example/page")],
    [("referer", "http://localhost:8000.evil.example/")],
    [("referer", "about:blank")],
    [("cookie", "a=b")],
]
FORMS = ["application/x-www-form-urlencoded", "text/plain", "multipart/form-data; boundary=x"]
ALWAYS = {
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
}


async def assert_refused(method, headers, *statuses, paths=ADDRESSES, body=b""):
    for path in paths:
        await assert_refused_at(method, path, headers, statuses, body)


async def assert_each_refused(method, ways, *statuses):
    """Each way is refused somewhere and some way everywhere; with another method they meet elsewhere."""
    first = METHODS.index(method)
    turn = islice(cycle(ways), first, None)
    assert len(ADDRESSES) > len(ways)
    for path, headers in zip(ADDRESSES, turn, strict=False):
        await assert_refused_at(method, path, headers, statuses)


async def assert_refused_at(method, path, headers, statuses, body=b""):
    answer = await asked(APP, method, path, headers, body)
    assert answer.status in statuses, (method, path, headers, answer)
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers.items() >= ALWAYS.items()


@pytest.mark.parametrize("method", METHODS)
async def test_another_host_is_refused_everywhere(method):
    await assert_each_refused(method, [[("host", host)] for host in HOSTS], 400, 421)
    await assert_each_refused(method, ([], [HERE, HERE], [HERE, ("host", "evil.example")]), 400)


@pytest.mark.parametrize("method", METHODS)
async def test_what_a_proxy_says_of_the_host_counts_for_nothing(method):
    said = [("x-forwarded-host", "localhost:8000"), ("forwarded", "host=localhost"), ("x-host", "localhost")]

    await assert_refused(method, [("host", "evil.example"), *said], 421)


@pytest.mark.parametrize("method", METHODS)
async def test_another_origin_is_refused_everywhere(method):
    claimed = [[("origin", origin)] for origin in FOREIGN_ORIGINS]
    claimed += [[*one, ("sec-fetch-site", "same-origin")] for one in claimed]
    claimed.append([("origin", "http://localhost:8000"), ("origin", "null")])

    await assert_each_refused(method, [[HERE, *one] for one in claimed], 403)


@pytest.mark.parametrize("method", METHODS)
async def test_what_another_page_fetches_or_frames_is_refused_everywhere(method):
    await assert_each_refused(method, [[HERE, *headers] for headers in FOREIGN_FETCHES], 403)


@pytest.mark.parametrize("method", METHODS)
async def test_a_link_on_another_page_leads_to_pages_only(method):
    link = [
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "navigate"),
        ("sec-fetch-dest", "document"),
    ]
    elsewhere = ADDRESSES if method != "GET" else [path for path in ADDRESSES if not PAGES.fullmatch(path)]

    await assert_refused(method, [HERE, *link], 403, paths=elsewhere)


async def test_the_pages_that_a_link_may_lead_to_are_those_with_html():
    html = paths_answering(APP, HTMLResponse)

    assert html
    assert {path for path in paths_of(APP) if PAGES.fullmatch(path)} == html | NOUNS.keys()


@pytest.mark.parametrize("method", CHANGING)
async def test_a_change_that_a_browser_does_not_prove_to_be_ours_is_refused_everywhere(method):
    await assert_each_refused(method, [[HERE, *headers] for headers in UNPROVEN], 403)


@pytest.mark.parametrize("method", CHANGING)
@pytest.mark.parametrize("form", FORMS)
async def test_a_form_changes_nothing_with_a_body_or_without(method, form):
    taken = TAKING_FILES if form.startswith("multipart") else ()
    others = [path for path in ADDRESSES if path not in taken]

    for length in ("0", "3"):
        headers = [HERE, ("content-type", form), ("content-length", length)]
        await assert_refused(method, headers, 415, paths=others, body=b"a=b"[: int(length)])


@pytest.mark.parametrize("target", ["http://localhost:8000/health", "*", "", "health", "localhost:8000"])
async def test_a_target_that_is_no_path_is_refused(target):
    await assert_refused("GET", [HERE], 400, paths=[target])


@pytest.mark.parametrize("method", METHODS)
async def test_every_answer_says_who_may_show_it_and_what_may_run_in_it(method):
    for path in ADDRESSES:
        answer = await asked(APP, method, path)
        assert answer.headers.items() >= ALWAYS.items(), (method, path)
        policy = answer.headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; ")
        assert "frame-ancestors 'none'" in policy
        assert "unsafe" not in policy
        assert "cache-control" in answer.headers
        assert "access-control-allow-origin" not in answer.headers


async def test_a_failure_of_the_program_says_so_too():
    answer = await asked(APP, "GET", "/health")  # without a context behind it

    assert answer.status == 500
    assert answer.headers.items() >= ALWAYS.items()


async def test_websockets_are_refused():
    sent = []

    async def send(message):
        sent.append(message)

    await APP({"type": "websocket", "path": "/", "headers": [(b"host", b"localhost")]}, None, send)

    assert [message["type"] for message in sent] == ["websocket.close"]
    await assert_refused("GET", [HERE, ("connection", "upgrade"), ("upgrade", "websocket")], 400)


@pytest.mark.parametrize(
    "headers",
    [
        [],
        [("user-agent", "curl/8")],
        [("cookie", "a=b")],
        [("referer", "http://wiki.shop/")],
        [("origin", "http://localhost:8000")],
        [("sec-fetch-site", "same-origin"), ("sec-fetch-mode", "cors"), ("sec-fetch-dest", "empty")],
        [("sec-fetch-site", "none"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "document")],
    ],
)
async def test_scripts_own_pages_and_typed_addresses_read(headers):
    assert (await asked(APP, "GET", "/openapi.json", [HERE, *headers])).status == 200


@pytest.mark.parametrize(
    "headers",
    [
        [],
        [("user-agent", "Mozilla/5.0 (Windows NT; Windows NT 10.0; en-US) WindowsPowerShell/5.1")],
        [("origin", "http://localhost:8000"), ("sec-fetch-site", "same-origin")],
        [("sec-fetch-site", "same-origin")],
        [("referer", "http://localhost:8000/operator/3"), ("cookie", "a=b")],
    ],
)
async def test_scripts_and_own_pages_change(headers):
    assert (await asked(APP, "POST", "/openapi.json", [HERE, *headers])).status == 405


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("LOCALHOST:8000", "http://localhost:8000"),
        ("127.0.0.1", "http://127.0.0.1"),
        ("localhost:80", "http://localhost"),
        ("[::1]:8000", "http://[::1]:8000"),
        ("[0:0::1]:8000", "http://[::1]:8000"),
        ("cell3.shop:8000", "http://cell3.shop:8000"),
        ("proxy.shop", "https://proxy.shop"),
        ("proxy.shop:443", "https://proxy.shop"),
    ],
)
async def test_own_names_are_answered_with_their_own_origin(host, origin):
    assert (await asked(APP, "GET", "/openapi.json", [("host", host), ("origin", origin)])).status == 200


async def test_behind_tls_the_unprotected_page_of_that_name_is_another_one():
    headers = [("host", "proxy.shop"), ("origin", "http://proxy.shop")]

    assert (await asked(APP, "GET", "/openapi.json", headers)).status == 403


async def test_the_refusal_names_the_setting_that_would_allow_it():
    answer = await asked(APP, "GET", "/health", [("host", "cell4.shop:8000")])

    assert "--allowed-host cell4.shop" in answer.detail
    assert answer.headers["connection"] == "close"
