"""Acts on their way to the disk: one that the records do not allow keeps no other from it."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.machine import HANGS_S
from truepose.people.act_log import ActLog
from truepose.storage.errors import ConflictError
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
    assert "could not be put on record" in caplog.text
