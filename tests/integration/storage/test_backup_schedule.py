"""Copies on a schedule: made when one is due, so many kept, and failures said."""

import asyncio
import threading
from pathlib import Path

import pytest

from tests.helpers.storage.sessions import add
from truepose.storage.backup import schedule as backup_schedule
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.backup.schedule import BackupSchedule, back_up_at
from truepose.storage.drafts import DraftFolder
from truepose.storage.integrity.verification import verify_left

DAY_S = 86400.0


class Day:
    def __init__(self):
        self.now_s = 1_800_000_000.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def day():
    return Day()


@pytest.fixture
def schedule(database, tmp_path, day):
    return BackupSchedule(database.backend.url, BackupPlan(tmp_path / "copies", DAY_S, keep=2), day)


def copies(schedule):
    return sorted(path.name for path in schedule.plan.folder.iterdir())


async def test_a_copy_is_made_when_it_is_due_and_not_before(database, schedule, day):
    await add(database)
    assert schedule.age_s is None

    assert await schedule.make_if_due() == DAY_S
    day.now_s += 1000.0
    assert await schedule.make_if_due() == DAY_S - 1000.0

    assert copies(schedule) == ["truepose-20270115T080000Z.sqlite3"]
    assert schedule.age_s == 1000.0
    assert verify_left(schedule.plan.folder / copies(schedule)[0]).head == await database.head()


async def test_the_oldest_copies_make_room_and_nothing_else_does(schedule, day):
    schedule.plan.folder.mkdir()
    (schedule.plan.folder / "by-hand.sqlite3").write_text("somebody's own")
    for _ in range(4):
        await schedule.make_if_due()
        day.now_s += DAY_S

    assert copies(schedule) == [
        "by-hand.sqlite3",
        "truepose-20270117T080000Z.sqlite3",
        "truepose-20270118T080000Z.sqlite3",
    ]


async def test_drafts_go_with_the_copy_that_they_lie_beside(database, schedule, day):
    drafts = DraftFolder.beside(database.file)
    drafts.create()
    for _ in range(3):
        await schedule.make_if_due()
        day.now_s += DAY_S
    drafts.remove(1)
    await schedule.make_if_due()

    assert copies(schedule) == [
        "truepose-20270117T080000Z.sqlite3",
        "truepose-20270117T080000Z.sqlite3.drafts.zip",
        "truepose-20270118T080000Z.sqlite3",
    ]


@pytest.mark.parametrize("stamp", ["20991231T000000Z", "99999999T999999Z"])
async def test_a_name_of_no_moment_that_has_been_counts_for_no_copy(schedule, day, stamp):
    schedule.plan.folder.mkdir()
    strange = f"truepose-{stamp}.sqlite3"
    (schedule.plan.folder / strange).write_bytes(b"")
    assert schedule.age_s is None

    for _ in range(3):
        assert await schedule.make_if_due() == DAY_S
        day.now_s += DAY_S

    assert schedule.age_s == DAY_S
    assert copies(schedule) == [
        "truepose-20270116T080000Z.sqlite3",
        "truepose-20270117T080000Z.sqlite3",
        strange,
    ]


async def test_a_folder_that_cannot_be_read_is_said_and_looked_at_again_soon(schedule, monkeypatch):
    def unreadable(folder):
        raise PermissionError(13, "Permission denied")

    with monkeypatch.context() as locked:
        schedule.plan.folder.mkdir()
        locked.setattr(Path, "iterdir", unreadable)
        assert schedule.age_s is None
        assert await schedule.make_if_due() == 600.0
        assert "Permission denied" in schedule.fault

    assert copies(schedule) == []
    await schedule.make_if_due()
    assert (schedule.fault, len(copies(schedule))) == (None, 1)


async def test_a_schedule_that_ends_gives_up_the_copy_under_way_and_waits_for_that(schedule, monkeypatch):
    begun, go_on = asyncio.Event(), threading.Event()
    loop = asyncio.get_running_loop()

    def slow(*of):
        loop.call_soon_threadsafe(begun.set)
        go_on.wait(60)
        return back_up_at(*of)

    monkeypatch.setattr(backup_schedule, "back_up_at", slow)
    following = asyncio.create_task(schedule.make_if_due())
    await begun.wait()

    following.cancel()
    await asyncio.wait({following}, timeout=0.1)
    let_go_early = following.done()
    go_on.set()
    await asyncio.gather(following, return_exceptions=True)

    assert (let_go_early, following.cancelled()) == (False, True)
    assert not schedule.plan.folder.exists() or copies(schedule) == []


async def test_a_copy_that_cannot_be_made_is_said_and_tried_again_soon(schedule):
    schedule.plan.folder.write_text("in the way")

    assert await schedule.make_if_due() == 600.0
    assert "cannot be copied" in schedule.fault

    schedule.plan.folder.unlink()
    await schedule.make_if_due()
    assert schedule.fault is None
