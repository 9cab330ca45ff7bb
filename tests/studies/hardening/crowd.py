"""Clients that want nothing but to be in the way, in a process of their own; for loopback only.

`python -m tests.studies.hardening.crowd PORT SECONDS SILENT SLOW` opens so many connections, and each anew
a second after it was closed. It prints one JSON line: for each kind how long the service kept a connection.
"""

import asyncio
import contextlib
import json
import resource
import sys
import time
from collections import defaultdict

_BREATH_S = 1.0
_DEAF_S = 20.0  # who does not read cannot see that the other side has closed, and leaves then
_HOST = b"Host: 127.0.0.1\r\n"
_HEAD = b"POST /api/v1/sessions HTTP/1.1\r\n" + _HOST + b"Content-Type: application/json\r\n"
# What each kind says at once, and then a byte a second.
KINDS = {
    "silent": (b"", b""),
    "half a head": (b"GET /health HTTP/1.1\r\n" + _HOST, b""),
    "slow head": (b"GET /health HTTP/1.1\r\n" + _HOST + b"X: ", b"x"),
    "slow body": (_HEAD + b"Content-Length: 100000\r\n\r\n{", b" "),
    "slow chunks": (_HEAD + b"Transfer-Encoding: chunked\r\n\r\n", b"1\r\n \r\n"),
    "deaf": (b"GET /openapi.json HTTP/1.1\r\n" + _HOST + b"\r\n", b""),
}
SLOW = [kind for kind in KINDS if kind != "silent"]


async def _once(port, kind):
    """Hold one connection until the other side closes it; returns how long that was."""
    first, more = KINDS[kind]
    reader, writer = await asyncio.open_connection(
        "127.0.0.1", port, limit=1024
    )  # read no further than it must
    begun_s = time.monotonic()
    closed = asyncio.create_task(asyncio.sleep(_DEAF_S) if kind == "deaf" else _closed(reader))
    try:
        writer.write(first)
        while not closed.done():
            await asyncio.wait([closed], timeout=_BREATH_S)
            if more and not closed.done():
                writer.write(more)
    finally:
        closed.cancel()
        writer.transport.abort()
    return time.monotonic() - begun_s


async def _closed(reader):
    with contextlib.suppress(ConnectionError):
        while await reader.read(4096):
            pass


async def _again_and_again(port, kind, end_s, kept):
    while time.monotonic() < end_s:
        with contextlib.suppress(OSError, TimeoutError):
            async with asyncio.timeout(end_s - time.monotonic()):
                kept[kind].append(await _once(port, kind))
        await asyncio.sleep(_BREATH_S)


async def crowd(port, seconds, silent, slow):
    """Return how long each connection of each kind was kept."""
    end_s = time.monotonic() + seconds
    kinds = ["silent"] * silent + [SLOW[number % len(SLOW)] for number in range(slow)]
    kept = defaultdict(list)
    await asyncio.gather(*(_again_and_again(port, kind, end_s, kept) for kind in kinds))
    return kept


def main(port, seconds, silent, slow):
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
    kept = asyncio.run(crowd(int(port), float(seconds), int(silent), int(slow)))
    told = {kind: {"closed": len(times), "longest_s": max(times)} for kind, times in kept.items() if times}
    sys.stdout.write(json.dumps(told) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
