"""A disk fills up while readings come in, and the database is taken away: what is kept, how soon it is said.

`python -m tests.studies.hardening.full_disk --out DIR [--runs N]` fills the file system of DIR, so that has
to be a small one (`mount -t tmpfs -o size=160m tmpfs DIR`). Each run measures until the disk refuses, also
without the reserve, and then makes room; removes the database; and puts another file in its place.
"""

import asyncio
import os
import shutil
import time
from dataclasses import dataclass, field

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.integrity.monitor import Guard
from truepose.storage.integrity.verification import verify_left
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository

_LARGEST = 256 * 2**20  # of a file system that is filled
_BLOCK = 64 * 1024
_PATIENCE_S = 30.0


@dataclass
class Filled:
    """What came of all runs."""

    runs: int = 0
    acknowledged: int = 0
    in_reserve: list = field(default_factory=list)  # readings taken after the disk was full
    lost: int = 0  # acknowledged, and not there at the end
    not_whole: int = 0  # databases with findings
    begun_while_full: int = 0  # sessions, which should be none
    taken_again_s: list = field(default_factory=list)  # readings, after there was room
    begins_again_s: list = field(default_factory=list)  # sessions
    back_s: list = field(default_factory=list)  # a removed database, at its place
    foreign_said_s: list = field(default_factory=list)  # another file in its place
    taken_beside_foreign: int = 0


class _Session:
    """Measures, and knows what was acknowledged."""

    def __init__(self, database, number):
        self.database, self.number, self.acknowledged = database, number, 0

    async def measure(self):
        reading = point_taken(make_point(self.acknowledged + 1))
        await LedgerRepository(self.database).append(self.number, reading)
        self.acknowledged += 1

    async def measure_until_refused(self):
        before = self.acknowledged
        while True:
            try:
                await self.measure()
            except StorageUnavailableError:
                return self.acknowledged - before


async def _until(happens):
    begun_s = time.perf_counter()
    async with asyncio.timeout(_PATIENCE_S):
        while not await happens():
            await asyncio.sleep(0.02)
    return time.perf_counter() - begun_s


def _fill(ballast):
    with ballast.open("wb", buffering=0) as file:
        for size in (_BLOCK, 512):
            while True:
                try:
                    file.write(os.urandom(size))
                except OSError:
                    break


async def _works(coroutine):
    try:
        await coroutine
    except StorageUnavailableError:
        return False
    return True


async def _of_one_disk(folder, found):
    database = Database(f"sqlite:///{folder}/cell.sqlite3")
    guarding = asyncio.create_task(Guard(database).follow())
    sessions = SessionRepository(database)
    session = _Session(database, await sessions.add("under way", make_setup(), make_plan()))
    for _ in range(5):
        await session.measure()
    await database.keep_reserve()
    await asyncio.to_thread(_fill, folder / "ballast")
    found.in_reserve.append(await session.measure_until_refused())
    found.begun_while_full += await _works(sessions.add("new", make_setup(), make_plan()))
    (folder / "ballast").unlink()
    found.taken_again_s.append(await _until(lambda: _works(session.measure())))
    found.begins_again_s.append(await _until(lambda: _works(sessions.add("new", make_setup(), make_plan()))))
    await _of_its_place(database, session, found)
    guarding.cancel()
    await asyncio.gather(guarding, return_exceptions=True)
    held = await database.read(lambda c: c.exec_driver_sql("SELECT count(*) FROM readings").scalar())
    database.close()
    found.acknowledged += session.acknowledged
    found.lost += max(0, session.acknowledged - held)
    found.not_whole += bool(verify_left(database.file).findings)


async def _of_its_place(database, session, found):
    async def is_back():
        return database.file.exists()

    async def is_said():
        return "Another file lies" in (database.condition.fault or "")

    database.file.unlink()
    found.back_s.append(await _until(is_back))
    await session.measure()
    away = database.file.with_name("away")
    database.file.rename(away)
    database.file.write_text("something else")
    found.foreign_said_s.append(await _until(is_said))
    found.taken_beside_foreign += await _works(session.measure())
    away.replace(database.file)
    await asyncio.wait_for(database.writable(), _PATIENCE_S)
    await session.measure()


async def full_disk(folder, runs):
    """Fill the disk so often."""
    if shutil.disk_usage(folder).total > _LARGEST:
        raise SystemExit(f"{folder} is on a file system that is too large to be filled.")
    found = Filled()
    for run in range(runs):
        fresh = folder / str(run)
        fresh.mkdir()
        await _of_one_disk(fresh, found)
        shutil.rmtree(fresh)
        found.runs += 1
    return found


def told(found):
    """Return what came of it, in words."""
    return (
        f"{found.runs} disks: {found.acknowledged} readings acknowledged, {found.lost} lost, "
        f"{found.not_whole} databases not whole; in the reserve {min(found.in_reserve)} readings or more; "
        f"{found.begun_while_full} sessions begun meanwhile; after room was made readings within "
        f"{max(found.taken_again_s):.2f} s, sessions within {max(found.begins_again_s):.2f} s; a removed "
        f"database back within {max(found.back_s):.2f} s, another file in its place told within "
        f"{max(found.foreign_said_s):.2f} s, {found.taken_beside_foreign} readings taken meanwhile\n"
    )


if __name__ == "__main__":
    from_command_line(__doc__, "full_disk", full_disk, told, runs=20)
