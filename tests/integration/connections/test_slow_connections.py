"""Who is silent, slow or deaf is closed; who is not goes on."""

import asyncio
import contextlib
import json
import socket
from dataclasses import replace

import pytest

from tests.helpers.machine import HANGS_S
from tests.integration.connections.conftest import TIGHT, connected, served, until_closed
from truepose.app.connections import Limits

GET = b"GET /3 HTTP/1.1\r\nHost: localhost\r\n\r\n"


@pytest.mark.parametrize(
    "said",
    [
        b"",
        b"GET / HT",
        b"GET /3 HTTP/1.1\r\nHost: localhost\r\nX: y\r\n",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\nfirst",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n5\r\nfirst\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100\r\n\r\n",
    ],
)
async def test_who_never_finishes_a_request_is_closed(port, said):
    reader, writer = await connected(port, said)

    assert await until_closed(reader) == b""
    writer.close()


@pytest.mark.parametrize(
    "begin",
    [
        b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ",
        b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9999\r\n\r\n",
    ],
)
async def test_who_sends_a_byte_now_and_then_is_closed(port, begin):
    reader, writer = await connected(port, begin)
    closed = asyncio.create_task(until_closed(reader))

    with contextlib.suppress(ConnectionError):
        while not closed.done():
            writer.write(b"x")
            await writer.drain()
            await asyncio.wait([closed], timeout=0.05)

    assert await closed == b""
    writer.close()


async def test_who_does_not_read_the_answer_is_closed():
    async with served() as (port, census):
        with socket.create_connection(("127.0.0.1", port)) as deaf:
            deaf.sendall(b"GET /30000000 HTTP/1.1\r\nHost: localhost\r\n\r\n")
            async with asyncio.timeout(HANGS_S):
                for expected in (1, 0):
                    while len(census) != expected:
                        await asyncio.sleep(0.01)
            assert not census


async def test_a_stream_stays_open_and_is_not_closed_to_make_room():
    limits = Limits(connections=4, head_s=60.0)
    async with served(limits) as (port, _):
        stream, writer = await connected(port, b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n")
        await stream.readuntil(b"\r\n\r\n")
        silent = [await connected(port) for _ in range(10)]

        answers, other = await connected(port, GET)
        assert (await answers.readuntil(b"xxx")).startswith(b"HTTP/1.1 200")
        closed = [await until_closed(reader) for reader, _ in silent[:6]]

        assert closed == [b""] * 6
        assert not stream.at_eof()
        for opened in (writer, other, *(writer for _, writer in silent)):
            opened.close()


async def test_a_body_that_comes_as_it_should_is_not_closed_to_make_room():
    async with served(Limits(connections=4, head_s=60.0)) as (port, _):
        size = 2**21
        head = f"POST /3 HTTP/1.1\r\nHost: localhost\r\nContent-Length: {size}\r\n\r\n".encode()
        answer, sender = await connected(port, head + b"x" * (size // 2))
        silent = [await connected(port) for _ in range(10)]
        closed = [await until_closed(reader) for reader, _ in silent[:6]]
        sender.write(b"x" * (size // 2))

        assert closed == [b""] * 6
        assert (await answer.readuntil(b"xxx")).startswith(b"HTTP/1.1 200")
        for opened in (sender, *(writer for _, writer in silent)):
            opened.close()


async def test_a_connection_that_is_used_again_and_again_is_kept():
    limits = replace(TIGHT, head_s=1.5, answer_grace_s=1.5)  # a busy machine may take its time in between
    async with served(limits) as (port, _):
        reader, writer = await connected(port)
        loop = asyncio.get_running_loop()
        end_s = loop.time() + 1.5 * limits.head_s

        while loop.time() < end_s:
            writer.write(GET)
            assert b"HTTP/1.1 200" in await reader.readuntil(b"xxx\r\n0\r\n\r\n")
            await asyncio.sleep(limits.head_s / 30)
        writer.close()


async def test_a_connection_that_rests_between_two_requests_is_kept(port):
    reader, writer = await connected(port, GET)
    await reader.readuntil(b"xxx\r\n0\r\n\r\n")

    await asyncio.sleep(5 * TIGHT.head_s)
    writer.write(GET)

    assert b"HTTP/1.1 200" in await reader.readuntil(b"xxx\r\n0\r\n\r\n")
    writer.close()


@pytest.mark.parametrize("together", [False, True])
async def test_who_does_not_finish_a_second_request_is_closed(port, together):
    half = b"GET /3 HTTP/1.1\r\nHost: "
    reader, writer = await connected(port, GET + half if together else GET)
    await reader.readuntil(b"xxx\r\n0\r\n\r\n")
    if not together:
        writer.write(half)

    async with asyncio.timeout(20 * TIGHT.head_s):  # sooner than an idle connection would be
        assert await until_closed(reader) == b""
    writer.close()


async def test_what_is_no_http_gets_a_problem_with_all_headers(port):
    reader, writer = await connected(port, b"\x16\x03\x01\x02\x00\x01\r\n\r\n")

    head, _, body = (await until_closed(reader)).partition(b"\r\n\r\n")

    assert head.startswith(b"HTTP/1.1 400")
    assert b"x-frame-options: DENY" in head
    assert json.loads(body)["detail"] == "This is not an HTTP request."
    writer.close()


async def test_the_answer_to_what_is_no_http_outlives_what_follows_it(port):
    def answer_after_the_rest():
        with socket.create_connection(("127.0.0.1", port), timeout=HANGS_S) as client:
            client.sendall(b"\x16\x03\x01\x02\x00\x01\r\n\r\n")
            assert client.recv(1, socket.MSG_PEEK) == b"H"  # it is answered
            for _ in range(8):
                client.sendall(b"x" * 4096)
            client.shutdown(socket.SHUT_WR)
            return b"".join(iter(lambda: client.recv(65536), b""))

    answer = await asyncio.to_thread(answer_after_the_rest)

    assert answer.startswith(b"HTTP/1.1 400")
    assert answer.endswith(b"}")


async def test_nonsense_without_end_is_cut_off(port):
    _, writer = await connected(port, b"\x16\x03\x01\x02\x00\x01\r\n\r\n")

    with pytest.raises(ConnectionError):
        async with asyncio.timeout(HANGS_S):
            while True:
                writer.write(b"x" * 65536)
                await writer.drain()
    writer.close()


async def test_nonsense_behind_a_request_under_way_leaves_no_traceback(port, caplog):
    reader, writer = await connected(port, b"GET /events HTTP/1.1\r\nHost: localhost\r\n\r\n")
    await reader.readuntil(b"\r\n\r\n")
    writer.write(b"\x00 nonsense\r\n\r\n")

    writer.close()
    await until_closed(reader)

    assert not [record for record in caplog.records if record.exc_info]
