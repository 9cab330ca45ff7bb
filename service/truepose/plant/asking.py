"""What a plant asks of a cell, over its REST interface: the head, links, and to take what is handed down."""

import asyncio
import json
import re
import ssl
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, Final

import httpx

from truepose.exchange.cells.of_plant import PlantCell
from truepose.plant.clocks import Answered
from truepose.plant.errors import CellAnswerError, CellSilentError
from truepose.storage.plant.records import HandDownRecord

_PATIENCE: Final = httpx.Timeout(30.0, connect=10.0)
_LATE: Final = "no answer for half a minute, or no connection in ten seconds"
_MOST_BYTES: Final = 256 * 2**20  # of a page: one record of the largest kind, and no more than memory holds
_CREATED: Final = 201
_REFUSED: Final = frozenset({400, 409, 413, 422})  # for good: what stands in the hand-down itself
_OURS: Final = "urn:truepose:problem:"  # of a cell; what stands between here and there says no such thing
_SILENT: Final = (httpx.HTTPError, httpx.InvalidURL, OSError, UnicodeError)  # the last: no name of a host
_UNREADABLE: Final = (ArithmeticError, LookupError, RecursionError, TypeError, ValueError)
_NUMBERS: Final = range(2**63)  # that a database holds
_TOKEN: Final = re.compile("[!-~]+")  # what a header carries


@dataclass(frozen=True, slots=True)
class CellHead:
    """How far the chain of a cell goes."""

    version: str
    schema: str  # of its database
    newest: int  # link
    head: str  # with the links asked for
    clock: Answered


@dataclass(frozen=True, slots=True)
class CellPage:
    """Some links, as they came, and how far the chain goes."""

    lines: list[dict[str, Any]]
    newest: int


@dataclass(frozen=True, slots=True)
class Handed:
    """What a cell said to a hand-down: taken under a number, or refused with a sentence."""

    number: int | None
    sentence: str


class AskedCell:
    """One cell, reached as its entry in the cells file says."""

    def __init__(
        self,
        cell: PlantCell,
        wall_time: Callable[[], datetime] | None = None,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        """Ask a cell by a clock, by default this computer's, over a transport, by default the network."""
        self._cell = cell
        self._wall_time = wall_time or _wall_time
        self._transport = transport
        self._client: httpx.AsyncClient | None = None

    async def head(self, links: int | None = None) -> CellHead:
        """Return how far the chain goes, its head with so many links, the time; raises CellAnswerError."""
        asked_at, begun_s = self._wall_time(), time.monotonic()
        answer = await self._get("/chain/head", {} if links is None else {"links": links})
        took_s = time.monotonic() - begun_s
        try:
            told = json.loads(answer)
            return CellHead(
                version=_text(told["version"]),
                schema=_text(told["schema"]),
                newest=_number(told["newest"]),
                head=str(told["head"]),
                clock=Answered(asked_at, took_s, _moment(told["time"])),
            )
        except _UNREADABLE as error:
            raise self._no_cell(f"its head cannot be read ({error})") from error

    async def links(self, after: int, limit: int) -> CellPage:
        """Return links above a number; raises CellAnswerError, also for a page that was cut off."""
        answer = await self._get("/chain/links", {"after": after, "limit": limit})
        try:
            return await asyncio.to_thread(_page, answer)
        except _UNREADABLE as error:
            raise self._no_cell(f"a page of its chain was cut off or cannot be read ({error})") from error

    async def hand_down(self, record: HandDownRecord, key: str) -> Handed:
        """Have a cell keep a plan or a model; the key lets it be kept once.

        Raises CellAnswerError where the cell has neither taken nor refused it.
        """
        told = record.hand_down
        said = {"kind": told.kind.value, "name": told.name, "person": told.person, "document": told.document}
        try:
            body = json.dumps(said, allow_nan=False).encode()
        except ValueError:  # kept by a version that took such numbers
            return Handed(None, "It holds a number that is not finite, which JSON cannot say")
        answer = await self._post("/hand-downs", body, key)
        if answer.status_code == _CREATED:
            return Handed(self._created(answer), "")
        if answer.status_code in _REFUSED and _said(answer.content, "type").startswith(_OURS):
            return Handed(None, _detail(answer.content))
        raise self._no_cell(f"it answers {answer.status_code}: {_detail(answer.content)}")

    async def close(self) -> None:
        """Let go of the connection."""
        if self._client is not None:
            await self._client.aclose()
            self._client = None

    async def _get(self, path: str, parameters: dict[str, int]) -> bytes:
        try:
            client = await self._connected()
            async with client.stream("GET", f"/api/v1{path}", params=parameters) as answer:
                body = await self._body(answer)
        except _SILENT as error:
            raise self._unreachable(error) from error
        if answer.status_code != httpx.codes.OK:
            raise self._no_cell(f"it answers {answer.status_code}: {_detail(body)}")
        return body

    async def _post(self, path: str, body: bytes, key: str) -> httpx.Response:
        headers = {"Content-Type": "application/json", "Idempotency-Key": key}
        try:
            client = await self._connected()
            return await client.post(f"/api/v1{path}", content=body, headers=headers)
        except _SILENT as error:
            raise self._unreachable(error) from error

    def _created(self, answer: httpx.Response) -> int:
        try:
            return _number(json.loads(answer.content)["id"])
        except _UNREADABLE as error:
            raise self._no_cell(f"what it says to a hand-down cannot be read ({error})") from error

    async def _body(self, answer: httpx.Response) -> bytes:
        body = bytearray()
        async for part in answer.aiter_bytes():
            body += part
            if len(body) > _MOST_BYTES:
                raise self._no_cell("a page of its chain has no end")
        return bytes(body)

    async def _connected(self) -> httpx.AsyncClient:
        """Return the connection; made when it is needed, so that a token that was renewed counts."""
        if self._client is None:
            token = self._token()
            trusted = await asyncio.to_thread(_trusted, self._cell)
            self._client = httpx.AsyncClient(
                base_url=self._cell.url,
                headers={"Authorization": f"Bearer {token}"} if token else {},
                timeout=_PATIENCE,
                verify=trusted,
                trust_env=False,
                transport=self._transport,
            )
        return self._client

    def _token(self) -> str:
        file = self._cell.token_file
        if file is None:
            return ""
        try:
            token = file.read_text(encoding="utf-8-sig").strip()
        except (OSError, ValueError) as error:
            raise self._no_token(file, f"cannot be read ({error})") from error
        if not _TOKEN.fullmatch(token):
            raise self._no_token(file, "holds no token")
        return token

    def _no_token(self, file: Path, said: str) -> CellAnswerError:
        return CellAnswerError(
            f"{self._cell.name} is not asked: its token file {file} {said}; write into it the secret that "
            "'truepose people token' printed, as plain text."
        )

    def _unreachable(self, error: Exception) -> CellSilentError:
        said = _LATE if isinstance(error, httpx.TimeoutException) else str(error) or type(error).__name__
        return CellSilentError(f"{self._cell.name} cannot be reached at {self._cell.url} ({said}).")

    def _no_cell(self, said: str) -> CellAnswerError:
        return CellAnswerError(f"{self._cell.name} does not answer as a cell does: {said}.")


def _wall_time() -> datetime:
    return datetime.now(UTC)


def _number(told: Any) -> int:
    if type(told) is not int or told not in _NUMBERS:
        raise ValueError(f"{told!r:.40} is no number of a record")
    return told


def _text(told: Any) -> str:
    if not isinstance(told, str) or not told.isprintable():
        raise ValueError(f"{told!r:.40} is no text")
    return told


def _moment(told: Any) -> datetime:
    moment = datetime.fromisoformat(told)
    if moment.tzinfo is None:
        raise ValueError(f"{told!r:.40} is a time without a zone")
    return moment


def _page(answer: bytes) -> CellPage:
    *lines, end = [json.loads(line) for line in answer.splitlines()]
    return CellPage(lines, _number(end["newest"]))


def _trusted(cell: PlantCell) -> ssl.SSLContext:
    if not cell.url.startswith("https:"):
        return ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)  # nobody: it says nothing under TLS
    return _public() if cell.certificate is None else ssl.create_default_context(cafile=str(cell.certificate))


@cache
def _public() -> ssl.SSLContext:
    """Return whom everybody trusts; read once: 40 cells that are away would hold up all pages by it."""
    return httpx.create_ssl_context(trust_env=False)


def _detail(body: bytes) -> str:
    return _said(body, "detail").rstrip(".") or "without a sentence"


def _said(body: bytes, name: str) -> str:
    """Return what a problem document says; empty: nothing, or it is none."""
    try:
        return str(json.loads(body)[name])
    except _UNREADABLE:
        return ""
