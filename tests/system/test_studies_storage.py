"""The studies of the storage run, a little of each; what they measure is measured on a quiet machine."""

import asyncio

from tests.studies.durable_writes import durable
from tests.studies.ready_again import ready_again
from tests.studies.storage_refusals import refusals
from tests.studies.tampering import KINDS, tampering


async def test_sessions_whose_database_refuses_lose_nothing_and_come_to_their_end(tmp_path):
    tally = await refusals(tmp_path, 6, seed=3, lock_s=1.0)

    assert (tally.runs, tally.lost, tally.stuck, tally.damaged) == (6, 0, [], 0)
    assert tally.acknowledged > 0


async def test_whatever_is_tampered_with_is_noticed(tmp_path):
    tally = await tampering(tmp_path, len(KINDS), seed=2)

    assert tally.missed == []
    assert sum(tally.noticed.values()) + sum(tally.harmless.values()) == len(KINDS)


async def test_writes_are_counted(tmp_path):
    found = await durable(tmp_path, writes=4, readings=40, runs=1)

    assert found.readings >= 40
    assert found.ratio > 0


def test_a_killed_service_is_ready_again_and_everything_is_whole(tmp_path):
    found = asyncio.run(ready_again(tmp_path, readings=200, runs=1))

    assert len(found.ready_s) == 1
    assert found.integrity == "whole"
