"""Durable small writes: one writer against sixteen, and a reading early and late in a long session.

`python -m tests.studies.hardening.durable_writes --out DIR [--writes N] [--readings N] [--runs N]`
alternates between one writer and sixteen on the same database, so that a disk that slows down slows both.
"""

import asyncio
import statistics
import time
from dataclasses import dataclass

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.studies.running import from_command_line
from truepose.storage.connection.sqlite.library import VERSION
from truepose.storage.database import Database
from truepose.storage.measurement.ledger import LedgerRepository
from truepose.storage.measurement.sessions import SessionRepository

WRITERS = 16


@dataclass(frozen=True)
class Durable:
    """How fast readings reached the disk."""

    sqlite: str
    one_per_s: tuple[float, ...]  # of each run
    sixteen_per_s: tuple[float, ...]
    ratio: float  # of the medians
    readings: int  # in the session, at its end
    early_ms: float  # median of one reading
    late_ms: float


class _Session:
    def __init__(self, ledger, number):
        self._ledger, self._number, self.taken = ledger, number, 0

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


async def durable(folder, writes, readings, runs):
    """Write and return how fast that was."""
    database = Database(f"sqlite:///{folder}/truepose.sqlite3")
    number = await SessionRepository(database).add("long", make_setup(), make_plan())
    session = _Session(LedgerRepository(database), number)
    early_ms = await session.median_ms(writes)
    one, sixteen = [], []
    for _ in range(runs):
        one.append(await session.rate(1, writes))
        sixteen.append(await session.rate(WRITERS, max(1, writes // 4)))
    while session.taken < readings:
        await session.rate(200, 10)
    late_ms = await session.median_ms(writes)
    database.close()
    ratio = statistics.median(sixteen) / statistics.median(one)
    return Durable(VERSION, tuple(one), tuple(sixteen), ratio, session.taken, early_ms, late_ms)


def told(found):
    """Return what was found, in words."""
    return (
        f"SQLite {found.sqlite}: 1 writer {statistics.median(found.one_per_s):.0f}/s, "
        f"{WRITERS} writers {statistics.median(found.sixteen_per_s):.0f}/s, ratio {found.ratio:.2f}\n"
        f"one reading: {found.early_ms:.2f} ms early, {found.late_ms:.2f} ms after {found.readings}\n"
    )


if __name__ == "__main__":
    from_command_line(__doc__, "durable_writes", durable, told, writes=300, readings=50_000, runs=5)
