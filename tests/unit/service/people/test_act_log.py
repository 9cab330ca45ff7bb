"""Acts on their way to the disk, which refuses one of them or all."""

import asyncio
import re
from dataclasses import replace

import pytest

from tests.helpers.machine import HANGS_S
from truepose.people import act_log
from truepose.people.act_log import ActLog
from truepose.people.errors import ActsUnwrittenError
from truepose.storage.errors import ConflictError, StorageUnavailableError
from truepose.storage.people import PersonsAct

ACT = PersonsAct("2026-03-03T09:00:00.000+00:00", "confirm_session", "/api/v1/sessions/1/commands", 200)


class Records:
    """Keep everything but acts of an operation with a zero byte, as a server does."""

    def __init__(self):
        self.kept = []

    async def add(self, several):
        if any("\0" in act.operation for act in several):
            raise ConflictError("The records do not allow that; nothing was kept.")
        self.kept += several


@pytest.mark.parametrize("place", [0, 1, 2])
async def test_an_act_that_cannot_be_kept_leaves_all_others_on_record(place, caplog):
    records = Records()
    log = ActLog(records, lambda: asyncio.sleep(0))
    following = asyncio.create_task(log.follow())
    acts = [replace(ACT, status=200 + k) for k in range(3)]
    noted = [*acts[:place], replace(ACT, operation="GET \0"), *acts[place:]]

    for act in noted:
        log.note(act)
    await asyncio.wait_for(log.written(), HANGS_S)
    log.note(replace(ACT, status=404))
    await asyncio.wait_for(log.written(), HANGS_S)
    log.end()
    await following

    assert records.kept == [*acts, replace(ACT, status=404)]
    assert "could not be recorded" in caplog.text


class FullDisk:
    """Refuses every act, and says when the first one was refused."""

    def __init__(self):
        self.refused = asyncio.Event()

    async def add(self, several):
        self.refused.set()
        raise StorageUnavailableError("The disk is full.")


class SlowDisk:
    """Takes an act and never says so."""

    async def add(self, several):
        await asyncio.Event().wait()


def never():
    return asyncio.Event().wait()


async def test_a_full_disk_keeps_no_service_from_ending(caplog):
    disk = FullDisk()
    log = ActLog(disk, never)
    following = asyncio.create_task(log.follow())
    log.note(ACT)
    await asyncio.wait_for(disk.refused.wait(), HANGS_S)

    log.end()
    await asyncio.wait_for(following, HANGS_S)

    assert "1 actions could not be recorded" in caplog.text


@pytest.mark.parametrize(
    ("disk", "why"), [(FullDisk(), "The disk is full"), (SlowDisk(), "the disk is slow")]
)
async def test_whoever_reads_acts_is_told_that_the_disk_takes_none(disk, why, monkeypatch):
    monkeypatch.setattr(act_log, "PATIENCE_S", 0.01)
    log = ActLog(disk, never)
    following = asyncio.create_task(log.follow())
    log.note(ACT)

    with pytest.raises(ActsUnwrittenError, match=re.escape(f"({why})")):
        await asyncio.wait_for(log.written(), HANGS_S)

    following.cancel()
    await asyncio.wait({following})
