"""A tracker session whose database refuses: the whole service in this process, devices that answer at once.

A client keeps its own ledger of every reading that the service has shown; each must be in the database at
the end, unchanged.
"""

import asyncio
import contextlib
import os
import time
from collections.abc import AsyncIterator
from pathlib import Path
from random import Random
from typing import Any

import httpx

from service.app import create_app
from service.settings import Settings
from service.storage.arrival import verify_left
from service.storage.database import Database
from tests.integration.web.bench import CELL, Bench, session_request
from tests.studies.storage_refusals.outcome import Outcome
from tests.studies.storage_refusals.trouble import FAULTS, lasts_s

TRACKER_FAULTS = ("full", *FAULTS)
_STOPS = 6
_COMMITS = 60  # of the session until it happens, at most
_PATIENCE_S = 120.0
_PERSON = {"person": "Ada Byron"}
_PAGE = {"session_id": 1, "limit": 500}
_ANSWER_S = 60.0


class _Client:
    """Follows a session as a script would, and remembers every reading that it was shown."""

    def __init__(self, http: httpx.AsyncClient, rng: Random) -> None:
        self._http, self._rng = http, rng
        self.shown: dict[int, dict[str, Any]] = {}
        self.told = self.aborted = False

    async def ask(self, method: str, path: str, **more: Any) -> httpx.Response:
        return await self._http.request(method, f"/api/v1{path}", **more)

    async def begin(self) -> None:
        (await self.ask("POST", "/sessions", json=session_request(_STOPS))).raise_for_status()
        (await self.ask("POST", "/sessions/1/start")).raise_for_status()
        (await self.ask("POST", "/sessions/1/confirm", json=_PERSON)).raise_for_status()

    async def look(self) -> None:
        answer = await self.ask("GET", "/readings", params=_PAGE)
        if answer.is_success:
            self.shown |= {reading["id"]: reading for reading in answer.json()}
        health = (await self._http.get("/health")).json()
        self.told = self.told or health["status"] != "ok"

    async def press_for(self, lasts_s: float) -> None:
        """Press something now and then, as people do when nothing happens."""
        until_s = time.monotonic() + lasts_s
        while time.monotonic() < until_s:
            await self.look()
            await self._press()
            await asyncio.sleep(0.05)

    async def _press(self) -> None:
        match self._rng.randrange(6):
            case 0:
                await self.ask("POST", "/sessions/1/pause", json=_PERSON)
            case 1:
                await self.ask("POST", "/sessions/1/confirm", json=_PERSON)
            case 2:
                self.aborted = self.aborted or (await self.ask("POST", "/sessions/1/abort")).is_success
            case _:
                pass

    async def end(self) -> str:
        """Confirm whatever is asked until the session has ended; returns its state."""
        until_s = time.monotonic() + _PATIENCE_S
        state = "unknown"
        while time.monotonic() < until_s:
            answer = await self.ask("GET", "/sessions/1")
            if answer.is_success:
                state = answer.json()["state"]
            if state in {"finished", "aborted", "failed"}:
                break
            verb = {"awaiting_confirmation": "confirm", "paused": "resume", "planned": "start"}.get(state)
            if verb is not None:
                await self.ask("POST", f"/sessions/1/{verb}", json=_PERSON)
            await self.look()
            await asyncio.sleep(0.01)
        await self.look()
        return state

    async def lost(self) -> list[str]:
        """Name the readings that were shown and are not there, or not as shown."""
        kept = {
            reading["id"]: reading for reading in (await self.ask("GET", "/readings", params=_PAGE)).json()
        }
        return [
            f"Reading {number} was shown and is not kept as it was."
            for number, shown in self.shown.items()
            if _taken(kept.get(number)) != _taken(shown)
        ]


async def tracker_session(folder: Path, fault: str, rng: Random, lock_s: float) -> Outcome:
    """Run a session, have its database refuse at a random commit, and see what becomes of it."""
    outcome = Outcome("tracker", fault, "a commit", lasts_s(fault, rng, lock_s))
    async with _service(folder) as (database, http):
        client = _Client(http, rng)
        await client.begin()
        for _ in range(rng.randrange(_COMMITS)):
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(database.next_commit.wait(), 0.5)
        await client.look()
        async with _refusing(database, fault):
            await client.press_for(outcome.lasted_s)
        outcome.state = await client.end()
        outcome.wrong = await client.lost()
    outcome.told, outcome.kept = client.told, len(client.shown)
    outcome.came_to_its_end = outcome.state == "finished" or (outcome.state == "aborted" and client.aborted)
    outcome.wrong += verify_left(database.file).findings
    return outcome


@contextlib.asynccontextmanager
async def _service(folder: Path) -> AsyncIterator[tuple[Database, httpx.AsyncClient]]:
    cell = folder / "cell.toml"
    cell.write_text(CELL, encoding="utf-8")
    settings = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=cell)
    app = create_app(settings, Bench().registry())
    async with (
        app.router.lifespan_context(app),
        httpx.AsyncClient(
            transport=httpx.ASGITransport(app), base_url="http://localhost", timeout=_ANSWER_S
        ) as http,
    ):
        yield app.state.context.database, http


@contextlib.asynccontextmanager
async def _refusing(database: Database, fault: str) -> AsyncIterator[None]:
    if fault == "full":
        async with _full(database):
            yield
    else:
        with FAULTS[fault](database.file, os.getpid()):
            yield


@contextlib.asynccontextmanager
async def _full(database: Database) -> AsyncIterator[None]:
    """Have the library say that the disk is full, which no limit of a process does."""
    pages = await database.on_writer(lambda c: c.execute("PRAGMA page_count").fetchone()[0])
    await database.on_writer(lambda c: c.execute(f"PRAGMA max_page_count = {pages}"))
    yield
    # Not `on_writer`: that looks after the file first, which a full disk may refuse.
    most = "PRAGMA max_page_count = 1000000000"
    await asyncio.to_thread(database._writer.submit(lambda: database._raw.execute(most)).result)


def _taken(reading: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return what was read; that it was superseded since is another reading's matter."""
    return None if reading is None else {k: v for k, v in reading.items() if k != "superseded_by"}
