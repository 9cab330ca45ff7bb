"""Sessions whose database refuses at a random moment: full, locked, removed, without room for a byte.

`python -m tests.studies.storage_refusals --out DIR [--runs N] [--seed N] [--lock-s S]` runs sessions of the
whole service on devices that answer at once. A client keeps its own ledger of every reading that the service
has shown; at the end each of them must be in the database, unchanged, and the session must have finished, or
ended as asked, without a restart.
"""

import argparse
import asyncio
import contextlib
import json
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import httpx

from service.app import create_app
from service.settings import Settings
from service.storage.arrival import verify_left
from service.storage.engine import writing_engine
from tests.integration.web.bench import CELL, Bench, session_request

_STOPS = 6
_PATIENCE_S = 120.0
_PERSON = {"person": "Ada Byron"}
_FAULTS = ("full", "no bytes", "locked", "removed", "removed with its log", "moved away and back")


@dataclass
class Tally:
    """What became of the sessions."""

    runs: int = 0
    acknowledged: int = 0
    lost: int = 0  # readings that were shown and are not there, or not as shown
    ended: Counter = field(default_factory=Counter)  # by state
    stuck: list = field(default_factory=list)  # what was done to sessions that came to no end
    told: int = 0  # faults of which the service said something
    damaged: int = 0  # databases that do not verify


class _Trouble:
    """Has the database refuse, and lets it go again."""

    def __init__(self, kind, database, rng, lock_s):
        self._kind, self._database = kind, database
        self._lasts_s = rng.uniform(0.0, lock_s) if kind == "locked" else rng.uniform(0.0, 1.0)

    @contextlib.asynccontextmanager
    async def lasting(self):
        file = self._database.file
        match self._kind:
            case "full":
                pages = await self._database.on_writer(lambda c: c.execute("PRAGMA page_count").fetchone()[0])
                await self._database.on_writer(lambda c: c.execute(f"PRAGMA max_page_count = {pages}"))
                yield self._lasts_s
                most = "PRAGMA max_page_count = 1000000000"
                await asyncio.to_thread(lambda: self._database._writer.submit(self._raw, most).result())
            case "no bytes":
                before = resource.getrlimit(resource.RLIMIT_FSIZE)
                resource.setrlimit(resource.RLIMIT_FSIZE, (1, before[1]))
                yield self._lasts_s
                resource.setrlimit(resource.RLIMIT_FSIZE, before)
            case "locked":
                with contextlib.closing(writing_engine(file).raw_connection()) as other:
                    other.cursor().execute("BEGIN IMMEDIATE")
                    yield self._lasts_s
                    other.rollback()
            case "moved away and back":
                file.rename(file.with_name("away"))
                file.mkdir()
                yield self._lasts_s
                file.rmdir()
                file.with_name("away").rename(file)
            case _:
                file.unlink()
                if self._kind == "removed with its log":
                    for ending in ("-wal", "-shm"):
                        Path(f"{file}{ending}").unlink(missing_ok=True)
                yield self._lasts_s

    def _raw(self, statement):
        self._database._raw.execute(statement)


class _Client:
    """Follows a session as a script would, and remembers every reading that it was shown."""

    def __init__(self, http, rng):
        self._http, self._rng = http, rng
        self.shown, self.told, self.aborted = {}, False, False
        self._after = 0

    async def ask(self, method, path, **more):
        return await self._http.request(method, f"/api/v1{path}", **more)

    async def look(self):
        answer = await self.ask("GET", "/readings", params={"session_id": 1, "limit": 500})
        if answer.is_success:
            self.shown |= {reading["id"]: reading for reading in answer.json()}
        health = (await self._http.get("/health")).json()
        self.told = self.told or health["status"] != "ok"

    async def press(self):
        """Press something, as people do when nothing happens."""
        match self._rng.randrange(6):
            case 0:
                await self.ask("POST", "/sessions/1/pause", json=_PERSON)
            case 1:
                await self.ask("POST", "/sessions/1/confirm", json=_PERSON)
            case 2:
                self.aborted = self.aborted or (await self.ask("POST", "/sessions/1/abort")).is_success
            case _:
                pass

    async def end(self):
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


async def _session(folder, kind, rng, lock_s, tally):
    bench, cell = Bench(), folder / "cell.toml"
    cell.write_text(CELL)
    app = create_app(
        Settings(database_url=f"sqlite:///{folder}/truepose.sqlite3", cell_file=cell), bench.registry()
    )
    async with app.router.lifespan_context(app):
        database = app.state.context.database
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost", timeout=60) as http:
            client = _Client(http, rng)
            (await client.ask("POST", "/sessions", json=session_request(_STOPS))).raise_for_status()
            (await client.ask("POST", "/sessions/1/start")).raise_for_status()
            (await client.ask("POST", "/sessions/1/confirm", json=_PERSON)).raise_for_status()
            for _ in range(rng.randrange(60)):  # commits of the session until it happens
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(database.next_commit.wait(), 0.5)
            await client.look()
            async with _Trouble(kind, database, rng, lock_s).lasting() as lasts_s:
                until_s = time.monotonic() + lasts_s
                while time.monotonic() < until_s:
                    await client.look()
                    await client.press()
                    await asyncio.sleep(0.05)
            state = await client.end()
            kept = {reading["id"]: reading for reading in (await client.ask(
                "GET", "/readings", params={"session_id": 1, "limit": 500})).json()}  # fmt: skip
    tally.runs += 1
    tally.told += client.told
    tally.acknowledged += len(client.shown)
    tally.lost += sum(_taken(kept.get(number)) != _taken(shown) for number, shown in client.shown.items())
    tally.ended[state] += 1
    if state != "finished" and not (state == "aborted" and client.aborted):
        tally.stuck.append(kind)
    tally.damaged += bool(verify_left(database.file).findings)


def _taken(reading):
    """Return what was read; that it was superseded since is another reading's matter."""
    return None if reading is None else {k: v for k, v in reading.items() if k != "superseded_by"}


async def refusals(folder, runs, seed, lock_s):
    """Run so many sessions and return what became of them."""
    rng, tally = random.Random(seed), Tally()
    for run in range(runs):
        with tempfile.TemporaryDirectory(dir=folder) as fresh:
            await _session(Path(fresh), _FAULTS[run % len(_FAULTS)], rng, lock_s, tally)
    return tally


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--lock-s", type=float, default=60.0, help="A lock is held for up to so long.")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    tally = asyncio.run(refusals(options.out, options.runs, options.seed, options.lock_s))
    (options.out / "storage_refusals.json").write_text(json.dumps(vars(tally), indent=1))
    sys.stdout.write(
        f"{tally.runs} sessions, {tally.told} of which the service said something: "
        f"{tally.acknowledged} readings shown, {tally.lost} lost; ended {dict(tally.ended)}, "
        f"stuck {tally.stuck or 'none'}; "
        f"{tally.damaged} databases do not verify\n"
    )


if __name__ == "__main__":
    main()
