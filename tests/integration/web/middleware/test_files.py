"""What is sent to browsers: compressed where that is worth it, and not again where nothing has changed."""

import pytest

STYLE = "/static/look.css"
GZIP = {"Accept-Encoding": "gzip"}
AS_IT_IS = {"Accept-Encoding": "identity"}


@pytest.mark.parametrize(
    "path", [STYLE, "/static/report.css", "/static/tokens.css", "/static/tablet/common/page.js"]
)
async def test_a_file_is_sent_again_only_where_it_has_changed(client, path):
    first = await client.get(path)
    known = {"If-None-Match": first.headers["ETag"]}

    again = await client.get(path, headers=known)
    changed = await client.get(path, headers={"If-None-Match": 'W/"what it was"'})

    assert again.status_code == 304
    assert again.content == b""
    assert again.headers["Cache-Control"] == "private, no-cache"
    assert changed.content == first.content


@pytest.mark.parametrize("path", ["/", "/docs", STYLE, "/openapi.json"])
async def test_what_is_long_is_compressed_for_who_takes_it_so(client, path):
    packed, plain = await client.get(path, headers=GZIP), await client.get(path, headers=AS_IT_IS)

    assert packed.headers["Content-Encoding"] == "gzip"
    assert "Content-Encoding" not in plain.headers
    assert int(packed.headers["Content-Length"]) < int(plain.headers["Content-Length"]) / 2
    assert all("Accept-Encoding" in answer.headers["Vary"] for answer in (packed, plain))


@pytest.mark.parametrize("path", ["/health", "/api/v1/sessions", "/static/hold.js?x=1"])
async def test_what_is_short_is_sent_as_it_is(client, path):
    answer = await client.get(path, headers=GZIP)

    assert ("Content-Encoding" in answer.headers) == (len(answer.content) >= 1024)


async def test_a_stream_is_never_held_back_to_be_compressed(client):
    answer = await client.get("/api/v1/events?stop_after_s=0.01", headers=GZIP)

    assert answer.headers["Content-Type"].startswith("text/event-stream")
    assert "Content-Encoding" not in answer.headers
