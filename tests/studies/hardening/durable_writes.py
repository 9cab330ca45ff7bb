"""Durable small writes on each engine: one writer against sixteen, a reading early and late in a session.

`python -m tests.studies.hardening.durable_writes --out DIR [--writes N] [--readings N] [--runs N]` takes
turns with a file of SQLite and a PostgreSQL server on this machine, and with one writer and sixteen, so that
a disk that slows down slows all. The server keeps what it acknowledges (`fsync` on); without one it is left
out.
"""

import asyncio
import contextlib
import os
import statistics
import time
from dataclasses import dataclass
from unittest import mock

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.helpers.postgresql.server import own_server, programs
from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.engine.sqlite_connections import VERSION
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository

WRITERS = 16


@dataclass(frozen=True)
class Durable:
    """How fast readings reached the disk on one engine."""

    engine: str
    one_per_s: tuple[float, ...]  # of each run
    sixteen_per_s: tuple[float, ...]
    ratio: float  # of the medians
    readings: int  # in the session, at its end
    early_ms: float  # median of one reading
    late_ms: float


@dataclass(frozen=True)
class OnEachEngine:
    """The engines side by side."""

    engines: tuple[Durable, ...]
    load: float  # of the machine over the last minute, at the end


class _Session:
    def __init__(self, engine, url):
        self.engine, self._database = engine, Database(url)
        self._ledger = LedgerRepository(self._database)
        self.taken, self.one, self.sixteen, self.early_ms = 0, [], [], 0.0

    async def begin(self):
        self._number = await SessionRepository(self._database).add("long", make_setup(), make_plan())

    async def take(self):
        self.taken += 1
        await self._ledger.append(self._number, point_taken(make_point(self.taken)))

    async def rate(self, writers, each):
        begun_s, before = time.perf_counter(), self.taken

        async def write():
            for _ in range(each):
                await self.take()

        await asyncio.gather(*(write() for _ in range(writers)))
        return (self.taken - before) / (time.perf_counter() - begun_s)

    async def median_ms(self, count):
        waits = []
        for _ in range(count):
            begun_s = time.perf_counter()
            await self.take()
            waits.append(1000 * (time.perf_counter() - begun_s))
        return statistics.median(waits)

    async def found(self, late_ms):
        ratio = statistics.median(self.sixteen) / statistics.median(self.one)
        rates = tuple(self.one), tuple(self.sixteen), ratio
        return Durable(self.engine, *rates, self.taken, self.early_ms, late_ms)

    def close(self):
        self._database.close()


async def durable(folder, writes, readings, runs):
    """Write on each engine in turns and return how fast that was."""
    with contextlib.ExitStack() as stack:
        sessions = [*_opened(folder, stack)]
        for session in sessions:
            await session.begin()
            session.early_ms = await session.median_ms(writes)
        for _ in range(runs):
            for session in sessions:
                session.one.append(await session.rate(1, writes))
                session.sixteen.append(await session.rate(WRITERS, max(1, writes // 4)))
        found = []
        for session in sessions:
            while session.taken < readings:
                await session.rate(200, 10)
            found.append(await session.found(await session.median_ms(writes)))
        return OnEachEngine(tuple(found), os.getloadavg()[0])


def _opened(folder, stack):
    file = _Session(f"SQLite {VERSION}", f"sqlite:///{folder}/truepose.sqlite3")
    stack.callback(file.close)
    yield file
    if programs() is not None:
        server = stack.enter_context(own_server())
        stack.enter_context(mock.patch.dict(os.environ, {"XDG_DATA_HOME": str(folder)}))
        with server.connect() as connection:
            connection.execute("CREATE DATABASE cell")
            (version,) = connection.execute("SHOW server_version").fetchone()
        on_server = _Session(f"PostgreSQL {version.split()[0]}", server.url("cell"))
        stack.callback(on_server.close)
        yield on_server


def told(found):
    """Return what was found, in words."""
    lines = [
        f"{one.engine}: 1 writer {statistics.median(one.one_per_s):.0f}/s, "
        f"{WRITERS} writers {statistics.median(one.sixteen_per_s):.0f}/s, ratio {one.ratio:.2f}; "
        f"one reading: {one.early_ms:.2f} ms early, {one.late_ms:.2f} ms after {one.readings}\n"
        for one in found.engines
    ]
    return "".join(lines) + f"load {found.load:.1f}\n"


if __name__ == "__main__":
    from_command_line(__doc__, "durable_writes", durable, told, writes=300, readings=50_000, runs=5)
