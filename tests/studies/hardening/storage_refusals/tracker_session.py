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

from tests.helpers.web.clients import prompt_id
from tests.integration.web.bench import CELL, Bench, FakeRobot, session_request
from tests.studies.hardening.storage_refusals.outcome import TOO_LATE, Outcome
from tests.studies.hardening.storage_refusals.trouble import FAULTS, lasts_s
from truepose.app import create_app
from truepose.settings import Settings
from truepose.storage.database import Database
from truepose.storage.integrity.verification import verify_left

TRACKER_FAULTS = ("full", *FAULTS)
_STOPS = 12
_MOTIONS = 2 * _STOPS  # with an approach to each
_ENDED_BY_HAND = 0.25  # of the sessions that wait
_COMMITS = 3  # after a motion until it happens, at most
_PATIENCE_S = 120.0
_ENDED = {"finished", "aborted", "failed"}
_PERSON = {"person": "Ada Byron"}
_PAGE = {"session_id": 1, "limit": 500}
_ANSWER_S = 60.0


class _Client:
    """Follows a session as a script would, and remembers every reading that it was shown."""

    def __init__(self, http: httpx.AsyncClient, rng: Random) -> None:
        self._http, self._rng = http, rng
        self.shown: dict[int, dict[str, Any]] = {}
        self._ends = rng.random() < _ENDED_BY_HAND
        self.told = self.aborted = False

    async def ask(self, method: str, path: str, **more: Any) -> httpx.Response:
        return await self._http.request(method, f"/api/v1{path}", **more)

    async def begin(self) -> None:
        (await self.ask("POST", "/sessions", json=session_request(_STOPS))).raise_for_status()
        (await self.command("start")).raise_for_status()
        (await self.command("confirm")).raise_for_status()

    async def command(self, name: str) -> httpx.Response:
        found = await self.ask("GET", "/sessions/1/situation")
        asked = prompt_id(found.json()) if found.is_success else None
        said = {"command": name, "prompt_id": asked, **_PERSON}
        return await self.ask("POST", "/sessions/1/commands", json=said)

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
                await self.command("pause")
            case 1:
                await self.command("confirm")
            case 2 if self._ends:
                self.aborted = self.aborted or (await self.command("abort")).is_success
            case _:
                pass

    async def state(self) -> str | None:
        """Return the session's state; None where it is not told now."""
        answer = await self.ask("GET", "/sessions/1")
        return answer.json()["state"] if answer.is_success else None

    async def end(self) -> str:
        """Confirm whatever is asked until the session has ended; returns its state."""
        until_s = time.monotonic() + _PATIENCE_S
        state = "unknown"
        while time.monotonic() < until_s:
            state = await self.state() or state
            if state in _ENDED:
                break
            verb = {"awaiting_confirmation": "confirm", "paused": "resume", "planned": "start"}.get(state)
            if verb is not None:
                await self.command(verb)
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
    bench = Bench()
    async with _service(folder, bench) as (database, http):
        client = _Client(http, rng)
        bench.robot.gate.clear()
        await client.begin()
        await _motions(bench.robot, rng.randrange(_MOTIONS))
        await client.look()
        bench.robot.gate.set()
        await _commits(database, rng.randrange(_COMMITS))
        if bench.robot.moves == _MOTIONS:
            outcome.moment = TOO_LATE
        async with _refusing(database, fault):
            await client.press_for(outcome.lasted_s)
        outcome.state = await client.end()
        outcome.wrong = await client.lost()
    outcome.told, outcome.kept = client.told, len(client.shown)
    outcome.came_to_its_end = outcome.state == "finished" or (outcome.state == "aborted" and client.aborted)
    outcome.wrong += verify_left(database.file).findings
    return outcome


async def _motions(robot: FakeRobot, number: int) -> None:
    """Let the arm move so often, and return while it is about to move once more."""
    for _ in range(number):
        await robot.sent.wait()
        robot.sent.clear()
        robot.gate.set()  # who waits goes on, who comes next waits again
        robot.gate.clear()
    await robot.sent.wait()


async def _commits(database: Database, most: int) -> None:
    for _ in range(most):
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(database.next_commit.wait(), 0.5)


@contextlib.asynccontextmanager
async def _service(folder: Path, bench: Bench) -> AsyncIterator[tuple[Database, httpx.AsyncClient]]:
    cell = folder / "cell.toml"
    cell.write_text(CELL, encoding="utf-8")
    settings = Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=cell)
    app = create_app(settings, bench.registry())
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
    await asyncio.to_thread(database._writer.submit(lambda: database.backend.plain.execute(most)).result)


def _taken(reading: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return what was read; that it was superseded since is another reading's matter."""
    return None if reading is None else {k: v for k, v in reading.items() if k != "superseded_by"}
