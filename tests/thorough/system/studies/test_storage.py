"""The studies of the storage run, a little of each; what they measure is measured on a quiet machine."""

import asyncio
from random import Random

import pytest

from tests.integration.web.ballbar_bench import PLACEMENT
from tests.studies.hardening.durable_writes import durable
from tests.studies.hardening.ready_again import ready_again
from tests.studies.hardening.session_overhead import overhead
from tests.studies.hardening.storage_refusals.ballbar_session import ballbar_session
from tests.studies.hardening.storage_refusals.tracker_session import tracker_session
from tests.studies.hardening.tampering import KINDS, tampering
from tests.studies.single_changes import KINDS as SINGLE_CHANGES
from tests.studies.single_changes import single_changes
from tests.studies.taken_up.begun import begin

pytestmark = pytest.mark.usefixtures("forked_processes")

_LOCK_S = 1.0


@pytest.mark.parametrize("fault", ["full", "locked", "removed with its log"])
async def test_a_tracker_session_whose_database_refuses_loses_nothing_and_comes_to_its_end(tmp_path, fault):
    outcome = await tracker_session(tmp_path, fault, Random(3), _LOCK_S)

    assert outcome.came_to_its_end, outcome
    assert outcome.wrong == []
    assert outcome.kept > 0


async def test_a_ballbar_session_whose_database_refuses_in_a_motion_loses_and_doubles_nothing(tmp_path):
    begun = await begin("lrmate-tilted", 2, {"placements": [PLACEMENT]}, tmp_path / "begun", most=1)

    outcome = await ballbar_session(
        tmp_path, begun, "no bytes", "a pause in a motion", Random(4), _LOCK_S, further=2
    )

    assert outcome.came_to_its_end, outcome
    assert outcome.wrong == []
    assert outcome.moment == "a pause in a motion"
    assert outcome.kept > 0


async def test_whatever_is_tampered_with_is_noticed(tmp_path):
    tally = await tampering(tmp_path, len(KINDS), seed=2)

    assert tally.missed == []
    assert sum(tally.noticed.values()) + sum(tally.harmless.values()) == len(KINDS)


async def test_a_single_change_in_any_table_is_found_and_its_place_is_named(tmp_path):
    tally = await single_changes(tmp_path, 6 * len(SINGLE_CHANGES), seed=2)

    assert tally.missed == []
    assert sum(tally.found.values()) == 6 * len(SINGLE_CHANGES)


async def test_writes_are_counted(tmp_path):
    found = await durable(tmp_path, writes=4, readings=40, runs=1)

    assert [one.readings >= 40 and one.ratio > 0 for one in found.engines] == [True] * len(found.engines)


async def test_a_session_writes_few_lines_a_configuration(tmp_path):
    found = await overhead(tmp_path, configurations=10, runs=1)

    # Each waits for the disk; how long, no busy machine tells.
    assert 1.0 <= found.lines < 4.0


def test_a_killed_service_is_ready_again_and_everything_is_whole(tmp_path):
    found = asyncio.run(ready_again(tmp_path, readings=200, runs=1))

    assert len(found.ready_s) == 1
    assert found.integrity == "whole"
