"""Stand-ins of cells: each answers for its chain as a cell does, and has some new readings."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator, Sequence
from datetime import UTC, datetime
from typing import Any, Final
from urllib.parse import parse_qs, urlsplit

from tests.studies.plant_looks.rows import CellChain
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash
from truepose.storage.integrity.head_hash import head_of

_NEW: Final = 20  # readings that the plant has not collected
_FIRST_NEW: Final = 10**9  # number of a reading that no cell has yet


class StandIn:
    """Answers for the chain of one cell."""

    def __init__(self, chain: CellChain) -> None:
        self._chain = chain
        self._lines: list[dict[str, Any]] = []
        stream = max(chain.heads, default=1)
        hash_before = chain.heads.get(stream, GENESIS)
        for number in range(_FIRST_NEW, _FIRST_NEW + _NEW):
            row = {"id": number, "session_id": stream, "recorded_at": _time(), "document": "{}"}
            hash_before = linked_hash(hash_before, "readings", tuple(row), tuple(row.values()))
            link = chain.position + len(self._lines) + 1
            named = {"link": link, "stream": stream, "record": "readings", "record_id": number}
            self._lines.append({**named, "hash": hash_before.hex(), "row": row})

    def answer(self, target: str) -> bytes:
        """Return what a cell says to a request for a path."""
        parts = urlsplit(target)
        asked = {name: int(found) for name, (found,) in parse_qs(parts.query).items()}
        if parts.path.endswith("/head"):
            return self._head(asked["links"])
        return self._links(asked["after"], asked["limit"])

    @property
    def _newest(self) -> int:
        return self._chain.position + len(self._lines)

    def _head(self, at: int) -> bytes:
        heads = dict(self._chain.heads)
        for line in self._lines[: at - self._chain.position]:
            heads[line["stream"]] = bytes.fromhex(line["hash"])
        told = {"version": "study", "schema": "study", "newest": self._newest, "time": _time()}
        return json.dumps({**told, "head": head_of(at, heads).text}).encode()

    def _links(self, after: int, limit: int) -> bytes:
        some = self._lines[after - self._chain.position :][:limit]
        end = {"end": after + len(some), "newest": self._newest}
        return "".join(json.dumps(line) + "\n" for line in [*some, end]).encode()


@contextlib.asynccontextmanager
async def answering(chains: Sequence[CellChain]) -> AsyncIterator[list[str]]:
    """Have a stand-in for each chain as long as the context lasts; yields their addresses."""
    async with contextlib.AsyncExitStack() as stack:
        urls = []
        for chain in chains:
            server = await asyncio.start_server(_served(StandIn(chain)), "127.0.0.1", 0)
            await stack.enter_async_context(server)
            urls.append(f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}")
        yield urls


def _served(stand_in: StandIn) -> Any:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(asyncio.IncompleteReadError, ConnectionError):
            while True:
                request = (await reader.readuntil(b"\r\n\r\n")).decode()
                body = stand_in.answer(request.split(" ", 2)[1])
                writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(body) + body)
                await writer.drain()
        writer.close()

    return serve


def _time() -> str:
    return datetime.now(UTC).isoformat(timespec="microseconds")
