"""Room kept for a full disk: what is under way is brought to its end, and nothing new begins meanwhile."""

import asyncio
from types import SimpleNamespace

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.storage.sessions import add, measure, names
from truepose.storage.database import Database
from truepose.storage.engine import sqlite
from truepose.storage.errors import StorageUnavailableError

pytestmark = pytest.mark.engine("sqlite")  # a server has its own disk: server/test_refusals.py
MIB = 2**20


@pytest.fixture
def disk(database, monkeypatch):
    """A disk with so much room beside the reserve; the database is as large as it may get without it."""
    room = SimpleNamespace(free=1000 * MIB)
    monkeypatch.setattr(sqlite.shutil, "disk_usage", lambda folder: room)
    release = database.backend.reserve.release

    def fill():
        room.free = 0
        pages = "PRAGMA page_count"
        full = database._writer.submit(lambda: database.backend.plain.execute(pages).fetchone()[0]).result()
        set_most(database, full)

    def make_room():
        room.free = 1000 * MIB
        set_most(database, 2**31)

    def released():  # as on a disk: what the reserve held is there for others
        open_yet = not database.backend.connection.closed  # whoever closes it gives the room back last of all
        if open_yet and database.backend.reserve.file.exists():
            database.backend.plain.execute(f"PRAGMA max_page_count={2**31}")
        release()

    monkeypatch.setattr(database.backend.reserve, "release", released)
    return SimpleNamespace(fill=fill, make_room=make_room)


def set_most(database, pages):
    database._writer.submit(lambda: database.backend.plain.execute(f"PRAGMA max_page_count={pages}")).result()


async def test_a_full_disk_takes_the_readings_of_what_is_under_way(database, disk):
    session = await add(database)
    await database.keep_reserve()
    assert database.backend.reserve.file.stat().st_size == 16 * MIB

    disk.fill()
    await measure(database, session, 40)

    assert not database.backend.reserve.file.exists()
    assert database.condition.trouble is None
    assert "The disk is full" in database.condition.fault
    assert await database.read(lambda c: c.exec_driver_sql("SELECT count(*) FROM readings").scalar()) == 40


async def test_nothing_new_begins_until_there_is_room(database, disk):
    session = await add(database)
    await database.keep_reserve()
    disk.fill()
    await measure(database, session, 40)

    with pytest.raises(StorageUnavailableError, match="nothing new starts"):
        await add(database)
    await database.keep_reserve()
    with pytest.raises(StorageUnavailableError, match="nothing new starts"):
        await add(database)

    disk.make_room()
    await database.keep_reserve()
    await add(database)
    assert database.condition.fault is None
    assert database.backend.reserve.file.exists()
    assert await names(database) == ["first", "first"]


async def test_without_a_reserve_a_full_disk_refuses_as_ever(database, disk):
    session = await add(database)
    disk.fill()

    with pytest.raises(StorageUnavailableError, match="full"):
        await measure(database, session, 40)
    assert database.condition.low is None

    disk.make_room()
    await asyncio.wait_for(database.writable(), HANGS_S)


async def test_a_disk_with_little_room_is_left_to_others(database, monkeypatch):
    monkeypatch.setattr(sqlite.shutil, "disk_usage", lambda folder: SimpleNamespace(free=40 * MIB))

    await database.keep_reserve()

    assert not database.backend.reserve.file.exists()
    assert database.condition.fault is None


async def test_a_service_that_ends_leaves_no_reserve(database_url, monkeypatch):
    monkeypatch.setattr(sqlite.shutil, "disk_usage", lambda folder: SimpleNamespace(free=1000 * MIB))
    database = Database(database_url)
    await database.keep_reserve()
    assert database.backend.reserve.file.exists()

    database.close()

    assert not database.backend.reserve.file.exists()
