"""What a plant asks of a cell's service, and the cell's clock against the plant's.

On clocks: F. Cristian, Probabilistic clock synchronization, Distributed Computing 3 (1989), 146-158: an
answer that tells the time was given some time between question and answer, so the middle is off by half the
round trip at most. The quickest of several answers leaves least open. Nothing is set by it, nothing is put in
order by it.
"""

import asyncio
import json
import os
import re
import socket
import ssl
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from functools import cache
from pathlib import Path
from typing import Any, Final

import httpx

from truepose.exchange.cells.plant import PlantCell
from truepose.plant.errors import CellAnswerError, CellSilentError
from truepose.storage.plant.records import ClockSeen, HandDownRecord

_RESOLUTION_S: Final = 1e-6  # of a time as it is told


@dataclass(frozen=True, slots=True)
class ClockAnswer:
    """One question for the time, and its answer."""

    asked_at: datetime  # by the plant's clock
    took_s: float  # by a clock that nobody sets
    told: datetime  # by the cell's clock


def clock_seen(answers: Sequence[ClockAnswer]) -> ClockSeen:
    """Return how far a clock is off, by the quickest of the answers; there is one at least."""
    quickest = min(answers, key=lambda answer: answer.took_s)
    middle = quickest.asked_at + timedelta(seconds=quickest.took_s / 2)
    return ClockSeen((quickest.told - middle).total_seconds(), quickest.took_s / 2 + _RESOLUTION_S)


_PATIENCE: Final = httpx.Timeout(30.0, connect=10.0)
_LATE: Final = "no response within 30 s, or no connection within 10 s"
_ANSWER_S: Final = 60.0  # for an answer of next to nothing; and a second more for each of so many bytes
_SLOWEST: Final = 1000.0
_SLOW: Final = "its response arrives at less than 1000 bytes per second"
_MOST_BYTES: Final = 256 * 2**20  # of a page: one record of the largest kind, and no more than memory holds
# A refusal of megabytes once stood on the plant's first page (commit 7835de1b).
_LONGEST: Final = 500  # letters of what a cell says to people
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
    clock: ClockAnswer


@dataclass(frozen=True, slots=True)
class CellPage:
    """Some links, as they came, and how far the chain goes."""

    lines: list[dict[str, Any]]
    newest: int


@dataclass(frozen=True, slots=True)
class PushReply:
    """What a cell said to a hand-down: taken under a number, or refused with a sentence."""

    number: int | None
    sentence: str


class CellClient:
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
                head=_text(told["head"]),
                clock=ClockAnswer(asked_at, took_s, _moment(told["time"])),
            )
        except _UNREADABLE as error:
            raise self._no_cell(f"the head of its chain cannot be read ({error})") from error

    async def links(self, after: int, limit: int) -> CellPage:
        """Return links above a number; raises CellAnswerError, also for a page that was cut off."""
        answer = await self._get("/chain/links", {"after": after, "limit": limit})
        try:
            return await asyncio.to_thread(_page, answer)
        except _UNREADABLE as error:
            raise self._no_cell(f"a page of its chain was cut off or cannot be read ({error})") from error

    async def hand_down(self, record: HandDownRecord, key: str) -> PushReply:
        """Have a cell keep a plan or a model; the key lets it be kept once.

        Raises CellAnswerError where the cell has neither taken nor refused it.
        """
        told = record.hand_down
        said = {"kind": told.kind.value, "name": told.name, "person": told.person, "document": told.document}
        try:
            body = json.dumps(said, allow_nan=False).encode()
        except ValueError:  # kept by a version that took such numbers
            return PushReply(None, "It contains a number that is not finite, which JSON cannot represent")
        headers = {"Content-Type": "application/json", "Idempotency-Key": key}
        status, answer = await self._asked("POST", "/hand-downs", content=body, headers=headers)
        if status == _CREATED:
            return PushReply(self._created(answer), "")
        if status in _REFUSED and _said(answer, "type").startswith(_OURS):
            return PushReply(None, _detail(answer))
        raise self._no_cell(f"it returned status {status}: {_detail(answer)}")

    async def close(self) -> None:
        """Let go of the connection."""
        if self._client is not None:
            await self._client.aclose()
            self._client = None

    async def _get(self, path: str, parameters: dict[str, int]) -> bytes:
        status, body = await self._asked("GET", path, params=parameters)
        if status != httpx.codes.OK:
            raise self._no_cell(f"it returned status {status}: {_detail(body)}")
        return body

    async def _asked(self, method: str, path: str, **asked: Any) -> tuple[int, bytes]:
        """Return status and body of an answer; raises CellSilentError, also where it comes byte by byte."""
        try:
            client = await self._connected()
            patience_s = _ANSWER_S + len(asked.get("content", b"")) / _SLOWEST
            async with (
                asyncio.timeout(patience_s) as patience,
                client.stream(method, f"/api/v1{path}", **asked) as answer,
            ):
                return answer.status_code, await self._body(answer, patience)
        except _SILENT as error:
            raise self._unreachable(error) from error

    def _created(self, answer: bytes) -> int:
        try:
            return _number(json.loads(answer)["id"])
        except _UNREADABLE as error:
            raise self._no_cell(f"its reply to a deployment cannot be read ({error})") from error

    async def _body(self, answer: httpx.Response, patience: asyncio.Timeout) -> bytes:
        body = bytearray()
        async for part in answer.aiter_bytes():
            body += part
            if len(body) > _MOST_BYTES:
                raise self._no_cell(f"its response is longer than {_MOST_BYTES // 2**20} MB")
            # More time for what has come, at a least rate: the time-outs of the client begin anew with every
            # byte, and a cell that sent one now and then held its visit up for ever (commit 7835de1b).
            patience.reschedule((patience.when() or 0.0) + len(part) / _SLOWEST)
        return bytes(body)

    async def _connected(self) -> httpx.AsyncClient:
        """Return the connection; made when it is needed, so that a token that was renewed counts."""
        if self._client is None:
            token = self._token()
            trusted = await asyncio.to_thread(self._trusted)
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
            raise self._no_token(file, "contains no token")
        return token

    def _trusted(self) -> ssl.SSLContext:
        try:
            return _trusted(self._cell)
        except OSError as error:
            raise CellAnswerError(
                f"{self._cell.name} is not contacted: its certificate file {self._cell.certificate} cannot "
                f"be used ({error.strerror or error}). Give the PEM file of the cell's certificate or of its "
                "issuer."
            ) from error

    def _no_token(self, file: Path, said: str) -> CellAnswerError:
        return CellAnswerError(
            f"{self._cell.name} is not contacted: its token file {file} {said}. Put the secret printed by "
            "'truepose people token' into it as plain text."
        )

    def _unreachable(self, error: Exception) -> CellSilentError:
        said = _of_silence(error)
        return CellSilentError(f"{self._cell.name} cannot be reached at {self._cell.url} ({said}).")

    def _no_cell(self, said: str) -> CellAnswerError:
        return CellAnswerError(f"{self._cell.name} does not respond like a truepose cell: {said}.")


def _wall_time() -> datetime:
    return datetime.now(UTC)


def _of_silence(error: Exception) -> str:
    if isinstance(error, TimeoutError):
        return _SLOW
    if isinstance(error, httpx.TimeoutException):
        return _LATE
    return _of_system(error) or str(error) or type(error).__name__


def _of_system(error: BaseException | None) -> str:
    """Return why the system made no connection: nobody listens, or no way leads there; empty: it did."""
    while error is not None:
        found = error.exceptions[0] if isinstance(error, BaseExceptionGroup) else error
        if (
            isinstance(found, OSError)
            and found.errno
            and not isinstance(found, ssl.SSLError | socket.gaierror)
        ):
            return os.strerror(found.errno)
        error = found.__cause__ or found.__context__
    return ""


def _number(told: Any) -> int:
    if type(told) is not int or told not in _NUMBERS:
        raise ValueError(f"{told!r:.40} is not a record number")
    return told


def _text(told: Any) -> str:
    if not isinstance(told, str) or not told.isprintable() or len(told) > _LONGEST:
        raise ValueError(f"{told!r:.40} is not printable text")
    return told


def _moment(told: Any) -> datetime:
    moment = datetime.fromisoformat(told)
    if moment.tzinfo is None:
        raise ValueError(f"{told!r:.40} is a time without a time zone")
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
    return _said(body, "detail").rstrip(".") or "no reason given"


def _said(body: bytes, name: str) -> str:
    """Return what a problem document says, as far as people read it; empty: nothing, or it is none."""
    try:
        said = str(json.loads(body)[name])
    except _UNREADABLE:
        return ""
    return "".join(sign if sign.isprintable() else " " for sign in said[:_LONGEST])
