"""The ledger of a ballbar session: appended once, on disk when its number is known."""

from contextlib import closing
from dataclasses import replace

import pytest
from sqlalchemy import text

from tests.helpers.ballbar.sessions import LEGS, make_ballbar_plan, measured, moved, skipped
from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup
from truepose.domain.ballbar import PoseForecast, PreCalibration, Suspicion
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.storage.engine.reading import open_reader
from truepose.storage.errors import ConflictError, KeyReusedError
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.record_insertion import EventRepository
from truepose.storage.records import CommandAnswer, Page, RequestKey


@pytest.fixture
def sessions(database):
    return SessionRepository(database)


@pytest.fixture
def ledger(database):
    return LedgerRepository(database)


@pytest.fixture
async def session_id(sessions):
    return await sessions.add("first", make_setup(), make_ballbar_plan())


async def test_a_ballbar_session_comes_back_as_it_was_planned(sessions, session_id):
    record = await sessions.get(session_id)

    assert (record.role, record.state, record.planned) == ("ballbar", "planned", 2)
    assert (record.measured, record.skipped) == (0, 0)
    assert await sessions.ballbar_plan(session_id) == make_ballbar_plan()
    assert await sessions.setup(session_id) == make_setup()


async def test_sessions_of_both_kinds_share_their_numbers(sessions, session_id):
    other = await sessions.add("second", make_setup(), make_plan(3))

    listed = await sessions.page(Page())

    assert [(record.id, record.role, record.planned) for record in listed] == [
        (session_id, "ballbar", 2),
        (other, "calibration", 3),
    ]


async def test_an_entry_comes_back_as_it_was_written(ledger, session_id):
    forecast = PoseForecast(1, LEGS[:2], (300.0, 300.5), ((1e-4, 0.0), (0.0, 1e-4)))
    found = PreCalibration(make_ballbar_plan().placements[0].poses, (forecast,), 0.04, 12, (3,))
    entries = [
        measured("placement-1/pose-1/leg-1-1", person="Ada", tablet="t1", key="k1"),
        moved("placement-1/pose-1/move", (0.2,) * 6),
        LedgerEntry("placement-1/precalibrate-1", EntryKind.COMPUTED, 80.0, precalibration=found),
        LedgerEntry(
            "placement-1/pose-2/leg-2-3",
            EntryKind.SUSPECTED,
            90.0,
            suspicion=Suspicion("exchanged", (2, 3), (3, 3), 300.1, None),
        ),
    ]

    numbers = [await ledger.append(session_id, entry) for entry in entries]

    kept = await ledger.whole(session_id)
    assert [record.entry for record in kept] == entries
    assert [record.id for record in kept] == numbers == sorted(numbers)


async def test_entries_of_some_kinds_are_none_of_the_others(ledger, session_id):
    length = measured("placement-1/pose-1/leg-1-1", person="Ada", tablet="t1", key="k1")
    for entry in (
        length,
        moved("placement-1/pose-1/move", (0.2,) * 6),
        LedgerEntry("placement-1/pose-2", EntryKind.NOTED, 90.0),
    ):
        await ledger.append(session_id, entry)

    assert [one.entry for one in await ledger.of_kinds(session_id, (EntryKind.MEASURED,))] == [length]


async def test_entries_of_some_kinds_are_no_readings_of_a_tracker(ledger, sessions):
    number = await sessions.add("second", make_setup(), make_plan())
    skipped_by_ada = LedgerEntry("configuration-2", EntryKind.SKIPPED, 90.0, "Ada", text="hits the door")
    for entry in (
        LedgerEntry("configuration-1", EntryKind.MEASURED, 80.0, point=make_point()),
        skipped_by_ada,
    ):
        await ledger.append(number, entry)

    told = await ledger.of_kinds(number, (EntryKind.MEASURED, EntryKind.SKIPPED))

    assert [one.entry for one in told] == [skipped_by_ada]


async def test_a_repeated_key_returns_the_earlier_entry_and_changes_nothing(ledger, session_id):
    first = await ledger.append(session_id, measured("placement-1/pose-1/leg-1-1", key="k1"))

    again = await ledger.append(session_id, measured("placement-1/pose-1/leg-1-2", 299.0, key="k1"))

    assert again == first
    assert [record.entry.step_id for record in await ledger.whole(session_id)] == [
        "placement-1/pose-1/leg-1-1"
    ]
    assert (await ledger.entry_with(session_id, "k1")).id == first
    assert await ledger.entry_with(session_id, "k2") is None


async def test_keys_are_those_of_one_session(ledger, sessions, session_id):
    other = await sessions.add("second", make_setup(), make_ballbar_plan())

    first = await ledger.append(session_id, measured("placement-1/pose-1/leg-1-1", key="k1"))
    second = await ledger.append(other, measured("placement-1/pose-1/leg-1-1", key="k1"))

    assert first != second


async def test_pages_follow_the_numbers(ledger, session_id):
    numbers = [await ledger.append(session_id, measured(f"placement-1/pose-1/leg-1-{k}")) for k in (1, 2, 3)]

    page = await ledger.page(session_id, Page(after=numbers[0], limit=1))

    assert [record.id for record in page] == [numbers[1]]


async def test_what_is_written_is_on_disk_when_its_number_is_known(ledger, session_id, database):
    number = await ledger.append(session_id, measured("placement-1/pose-1/leg-1-1"))

    # Another connection sees committed transactions only.
    with closing(open_reader(database.backend.url)) as other:
        assert other.execute("SELECT id FROM session_entries").fetchall() == [(number,)]


@pytest.mark.parametrize("table", ["session_entries", "act_answers"])
@pytest.mark.parametrize("change", ["UPDATE {} SET session_id = 1", "DELETE FROM {}"])
async def test_nothing_that_happened_is_changed(ledger, session_id, database, table, change):
    number = await ledger.append(session_id, measured("placement-1/pose-1/leg-1-1"))
    await ledger.keep_answer(session_id, RequestKey("k", "f"), CommandAnswer("stored", number))

    with pytest.raises(ConflictError, match="never changed"):
        await database.write(lambda c: c.execute(text(change.format(table))))


async def test_poses_are_counted_from_the_ledger(ledger, sessions, session_id):
    for leg in ("leg-1-1", "leg-1-2"):
        await ledger.append(session_id, measured(f"placement-1/pose-1/{leg}"))
    await ledger.append(session_id, measured("placement-1/pose-2/initialise", 300.0))
    await ledger.append(session_id, measured("tool/side-1-2", 150.0))
    await ledger.append(session_id, skipped("placement-1/pose-2/move"))

    record = await sessions.get(session_id)

    assert (record.measured, record.skipped) == (1, 1)


async def test_an_entry_is_told_to_whoever_follows_the_events(ledger, session_id, database):
    number = await ledger.append(session_id, skipped("placement-1/pose-2/leg-1-1"))

    told = (await EventRepository(database).after(Page(), session_id=session_id))[-1]

    assert told.kind == "session.entry"
    assert told.document == {
        "entry": number,
        "step_id": "placement-1/pose-2/leg-1-1",
        "kind": "skipped",
        "text": "out of range",
    }


async def test_an_answer_is_kept_for_its_request(ledger, session_id):
    key = RequestKey("k", "fingerprint")
    await ledger.keep_answer(session_id, key, CommandAnswer("The reading is stored.", None))

    assert await ledger.answer_to(session_id, key) == CommandAnswer("The reading is stored.", None)
    assert await ledger.answer_to(session_id, replace(key, key="other")) is None
    with pytest.raises(KeyReusedError, match="another command"):
        await ledger.answer_to(session_id, replace(key, fingerprint="other"))


async def test_a_state_is_entered_with_the_entry_that_says_so(ledger, sessions, session_id):
    entry = LedgerEntry(
        "", EntryKind.CONTROL, 5.0, person="Ada", text="started", entered=SessionState.RUNNING
    )

    await ledger.append(session_id, entry)

    record = await sessions.get(session_id)
    assert (record.state, record.reason, record.person) == (SessionState.RUNNING, "started", "Ada")
    assert await ledger.newest(session_id) == 1


async def test_a_reason_that_begins_like_a_state_is_none(ledger, session_id):
    kept = LedgerEntry("tool/detach", EntryKind.SKIPPED, 5.0, text="paused: nobody was there")
    await ledger.append(session_id, kept)

    (record,) = await ledger.whole(session_id)

    assert record.entry == kept
