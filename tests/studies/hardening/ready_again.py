"""How soon a killed service is ready again on a database of a million readings, and how it lists them.

`python -m tests.studies.hardening.ready_again --out DIR [--readings N] [--runs N]` fills a database, then
starts the service as `truepose serve` does, asks `/health` until it answers, writes, and kills it, again
and again. The last one lists readings from the beginning, the middle and the end.
"""

import asyncio
import json
import statistics
import time
from dataclasses import dataclass

import httpx
import numpy as np

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup
from tests.integration.web.bench import CELL, session_request
from tests.studies.interruptions.killed_service import KilledService
from tests.studies.processes import memory_mb
from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.documents import to_document
from truepose.storage.integrity.hash_chain import linked_hash
from truepose.storage.ledger.sessions import SessionRepository

_AT_A_TIME = 20_000
_ADDRESS = 'host = "127.0.0.1"\nport = 9'
_CELL = CELL.replace('"fake_tracker"', f'"leica_emscon"\n{_ADDRESS}').replace(
    '"fake_robot"', f'"abb_open_abb"\n{_ADDRESS}'
)
_NAMES = ("id", "recorded_at", "session_id", "kind", "config", "nest", "time_s", "supersedes", "document")
_READING = f"INSERT INTO readings ({', '.join(_NAMES)}) VALUES ({', '.join('?' * len(_NAMES))})"
_LINK = "INSERT INTO links (stream, record, record_id, hash) VALUES (?, 'readings', ?, ?)"


@dataclass(frozen=True)
class Ready:
    """How soon the service answered, and how long its looking through everything took."""

    readings: int
    megabytes: float
    ready_s: tuple[float, ...]
    p95_s: float
    longest_health_s: float  # while everything was looked through, after the last start
    integrity: str
    page_ms: dict[str, float]  # median, by what was listed
    memory_mb: float  # of the service, after all that


async def _fill(database, readings):
    number = await SessionRepository(database).add("long", make_setup(), make_plan())
    document = json.dumps(to_document(make_point(1)))

    def add(first, last):
        def work(connection):
            cursor = connection.connection.cursor()
            newest = "SELECT hash FROM links WHERE stream = ? ORDER BY id DESC LIMIT 1"
            before = cursor.execute(newest, (number,)).fetchone()[0]
            rows, links = [], []
            for n in range(first, last):
                row = (n, "2026-05-04T09:12:33.125+00:00", number, "point", n, 1, 10.0 * n, None, document)
                before = linked_hash(before, "readings", _NAMES, row)
                rows.append(row)
                links.append((number, n, before))
            cursor.executemany(_READING, rows)
            cursor.executemany(_LINK, links)

        return work

    for first in range(1, readings + 1, _AT_A_TIME):
        await database.write(add(first, min(first + _AT_A_TIME, readings + 1)))


async def _busy_while_checked(service):
    """Ask for health until everything was looked through; returns the longest answer and what was found."""
    longest_s = 0.0
    async with httpx.AsyncClient(base_url=service.url, trust_env=False, timeout=60) as http:
        while True:
            begun_s = time.perf_counter()
            health = (await http.get("/health")).json()
            longest_s = max(longest_s, time.perf_counter() - begun_s)
            if health["integrity"]["state"] in {"whole", "damaged"}:
                return longest_s, health["integrity"]["state"]
            await asyncio.sleep(0.1)


_PAGES = {
    "readings, first": "/api/v1/readings?limit=100",
    "readings, middle": "/api/v1/readings?limit=100&after={middle}",
    "readings, last": "/api/v1/readings?limit=100&after={last}",
    "of the session, first": "/api/v1/sessions/1/readings?limit=100",
    "of the session, last": "/api/v1/sessions/1/readings?limit=100&after={last}",
    "sessions": "/api/v1/sessions",
    "metrics": "/metrics",
}


async def _listed(service, readings):
    """Return how long a page of each list takes, in the median of seven."""
    places = {"middle": readings // 2, "last": readings - 100}
    async with httpx.AsyncClient(base_url=service.url, trust_env=False, timeout=60) as http:
        return {name: await _median_ms(http, path.format(**places)) for name, path in _PAGES.items()}


async def _median_ms(http, path):
    took = []
    for _ in range(7):
        begun_s = time.perf_counter()
        (await http.get(path)).raise_for_status()
        took.append(1000 * (time.perf_counter() - begun_s))
    return statistics.median(took)


async def ready_again(folder, readings, runs):
    """Kill and start again so often."""
    file = folder / "truepose.sqlite3"
    database = Database(f"sqlite:///{file}")
    await _fill(database, readings)
    database.close()
    (folder / "cell.toml").write_text(_CELL)
    service = KilledService(folder / "cell.toml", file, folder / "service.log")
    ready_s = []
    for run in range(runs + 1):
        ready_s.append(await service.start())
        async with httpx.AsyncClient(base_url=service.url, trust_env=False) as http:
            (await http.post("/api/v1/sessions", json=session_request())).raise_for_status()
        if run < runs:
            await service.kill()
    try:
        longest_s, integrity = await _busy_while_checked(service)
        page_ms = await _listed(service, readings)
        taken_mb = memory_mb(service.pid)
    finally:
        await service.kill()
    after_kills = tuple(ready_s[1:])
    p95_s = float(np.quantile(after_kills, 0.95, method="higher"))
    return Ready(
        readings, file.stat().st_size / 1e6, after_kills, p95_s, longest_s, integrity, page_ms, taken_mb
    )


def told(found):
    """Return what was found, in words."""
    return (
        f"{found.readings} readings, {found.megabytes:.0f} MB: ready after {len(found.ready_s)} kills in "
        f"{min(found.ready_s):.2f} to {max(found.ready_s):.2f} s, p95 {found.p95_s:.2f} s; "
        f"looked through: {found.integrity}, /health within {found.longest_health_s:.2f} s meanwhile; "
        f"{found.memory_mb:.0f} MB; a page of 100 in ms: "
        + ", ".join(f"{name} {took:.0f}" for name, took in found.page_ms.items())
        + "\n"
    )


if __name__ == "__main__":
    from_command_line(__doc__, "ready_again", ready_again, told, readings=1_000_000, runs=40)
