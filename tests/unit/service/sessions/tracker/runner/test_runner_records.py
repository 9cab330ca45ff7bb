"""What a run leaves on record: after a restart, of its pace, of its devices and of the air."""

import asyncio
import math

import pytest

from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, begun, run_session
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose_drivers.api import Environment
from truepose_drivers.errors import (
    DeviceRefusedError,
)


def before_the_end(cell):
    """What a service had on disk that was killed just before the session had finished."""
    return tuple(cell.journal.entries[:-1])


def states(cell):
    return [state for state, _, _ in cell.journal.states]


async def test_a_restarted_session_asks_first_and_measures_only_what_is_missing():
    first = FakeCell()
    await run_session(first, make_plan(3))
    again = FakeCell()
    again.clock.time_s = first.clock.time_s
    entries = before_the_end(first)
    ran_s = first.journal.progress[-1].elapsed_s
    entries += (LedgerEntry("stop-4", EntryKind.SKIPPED, entries[-1].time_s, text="hidden"),)

    ended = await run_session(again, make_plan(6), entries=entries)

    assert ended is SessionState.FINISHED
    assert [point.config for point in again.journal.points] == [5, 6]
    assert again.journal.registrations == []  # the fixed nests agree with the one on disk
    assert states(again)[0] is SessionState.AWAITING_CONFIRMATION
    assert again.journal.progress[-1].done == 5
    assert again.journal.progress[-1].elapsed_s > ran_s


async def test_a_restart_after_the_tracker_was_moved_places_it_anew():
    first = FakeCell()
    await run_session(first, make_plan(1))
    again = FakeCell(azimuth_rad=0.4)
    operator = PatientOperator()

    ended = await run_session(again, make_plan(2), operator, before_the_end(first))

    assert ended is SessionState.FINISHED
    assert "Reference nest 1 was not found" in operator.questions[1]
    assert len(again.journal.registrations) == 1


async def test_a_journal_that_cannot_write_ends_the_session_as_failed(cell):
    cell.journal.full_disk_at = 1

    with pytest.raises(OSError, match="no space left"):
        await run_session(cell, make_plan(3))

    assert states(cell)[-1] is SessionState.FAILED
    assert len(cell.robot.moves) == 4


async def test_the_time_left_is_learnt_from_the_pace_in_cell_time(cell):
    await run_session(cell, make_plan(20))

    after_ten = next(p for p in cell.journal.progress if p.done == 10)
    # a stop here: two motions of 1.5 s, 4 s of rest, 1 s to find, 1 s to measure: 9 s;
    # and two looks at the fixed nests, now and last: 1 s to find and 1 s to measure each of three
    assert after_ten.remaining_s == pytest.approx(102.0, rel=0.01)
    assert cell.journal.progress[-1].remaining_s == 0.0
    assert cell.journal.progress[0].remaining_s is None


async def test_time_in_which_a_person_is_awaited_is_not_counted(cell):
    operator = PatientOperator()

    def think(question):
        cell.clock.time_s += 3600.0

    operator.before_answer = think

    await run_session(cell, make_plan(2), operator)

    assert cell.journal.progress[-1].elapsed_s < 600.0


async def test_devices_introduce_themselves_in_the_record(cell):
    await run_session(cell, make_plan(1))

    assert "The tracker is Leica AT401, serial 390001, firmware 3.8." in cell.journal.notes
    assert any("scale agrees with the certified lengths" in note for note in cell.journal.notes)


async def test_what_the_tracker_measures_with_and_in_which_air_is_in_the_record(cell):
    cell.tracker.settings = "The tracker measures the reflector RRR 0.5in."

    await run_session(cell, make_plan(1))

    assert cell.tracker.settings in cell.journal.notes
    assert "Air at the tracker: 23.1 °C, 1013.0 hPa, 40 % humidity." in cell.journal.notes


@pytest.mark.parametrize(
    ("air", "told"),
    [
        (Environment(23.1, math.nan, math.nan), ["Air at the tracker: 23.1 °C."]),
        (Environment(math.nan, math.nan, math.nan), ["Air at the tracker: not stated."]),
        (DeviceRefusedError("no weather station"), []),
    ],
)
async def test_air_that_no_station_measures_is_not_made_up(air, told, cell):
    cell.tracker.air = air

    await run_session(cell, make_plan(1))

    assert [note for note in cell.journal.notes if note.startswith("Air at")] == told
    assert not any("measures the" in note for note in cell.journal.notes)  # it says nothing of itself


async def test_a_cancelled_run_leaves_the_record_as_it_was(cell):
    _, running = await begun(cell, make_plan())

    running.cancel()

    with pytest.raises(asyncio.CancelledError):
        await running
    assert states(cell) == [SessionState.AWAITING_CONFIRMATION]
