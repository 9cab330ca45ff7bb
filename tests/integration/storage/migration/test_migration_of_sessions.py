"""Sessions that an older program left: read, taken up and made campaigns of, as those of this one are.

`tests/vectors/databases/schema_0008.sql` is what a program of schema 0008 had on disk: a finished
calibration and validation, a calibration that was killed after two readings and a skip, and to which somebody
then added a configuration, a ballbar session at lunch, and a session that was not begun.
"""

import json
from pathlib import Path

import pytest

from tests.integration.storage.migration.test_migration_of_models import ask, migrate
from tests.unit.service.sequencing.tracker.fakes import FakeCell
from tests.unit.service.sequencing.tracker.operators import PatientOperator
from truepose.analysis.campaigns.assembly import MeasuredSession, assemble_campaign
from truepose.domain.measurement.ledger import Control, EntryKind
from truepose.domain.measurement.session import SessionState
from truepose.sequencing.tracker.runner import TrackerRunner
from truepose.sequencing.tracker.situation import situation
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.database import Database
from truepose.storage.integrity.verification import verify
from truepose.storage.measurement.ledger import LedgerRepository
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.measurement.tracker_readings import ReadingRepository

OLD = Path(__file__).parents[3] / "vectors" / "databases" / "schema_0008.sql"
FINISHED, VALIDATION, KILLED, AT_LUNCH, NOT_BEGUN = 1, 2, 3, 4, 5
FIXED_NESTS = 3


@pytest.fixture
def file(tmp_path):
    return write_old(tmp_path / "truepose.sqlite3")


@pytest.fixture
def database(file):
    opened = Database(f"sqlite:///{file}")
    yield opened
    opened.close()


def write_old(file):
    connection = LIBRARY.connect(file)
    connection.executescript(OLD.read_text(encoding="utf-8"))
    connection.close()
    return file


async def entries(database, session_id):
    return tuple(record.entry for record in await LedgerRepository(database).whole(session_id))


async def stands(database, session_id):
    plan = await SessionRepository(database).plan(session_id)
    return situation(plan, FIXED_NESTS, await entries(database, session_id))


def test_no_record_is_changed_and_the_chain_goes_on(file):
    before = ask(file, "SELECT * FROM links ORDER BY id")
    documents = ask(file, "SELECT id, document FROM ballbar_entries")

    Database(f"sqlite:///{file}").close()

    assert ask(file, "SELECT * FROM links ORDER BY id")[: len(before)] == before
    ids = ", ".join(str(number) for number, _ in documents)
    assert ask(file, f"SELECT id, document FROM session_entries WHERE id IN ({ids})") == documents
    assert verify(file).findings == ()
    assert ask(file, "PRAGMA foreign_key_check") == []


@pytest.mark.parametrize("number", [1, 3])
def test_an_old_line_that_is_changed_afterwards_is_named(file, number):
    Database(f"sqlite:///{file}").close()
    with LIBRARY.connect(file) as connection:
        connection.execute("DROP TRIGGER session_entries_no_update")
        connection.execute("UPDATE session_entries SET step_id = 'tool/side-1-2' WHERE id = ?", (number,))
    connection.close()

    assert any(f"Record {number} of the " in finding for finding in verify(file).findings)


async def test_every_reading_of_a_session_has_its_line_in_order(database):
    lines = await entries(database, FINISHED)
    readings = ReadingRepository(database)

    assert [line.point for line in lines if line.point] == await readings.points(FINISHED)
    assert [line.fixed_nest for line in lines if line.fixed_nest] == await readings.fixed_nests(FINISHED)
    times = [line.time_s for line in lines]
    assert times == sorted(times)


async def test_finished_sessions_are_finished_and_those_not_begun_are_not(database):
    finished, not_begun = await stands(database, FINISHED), await stands(database, NOT_BEGUN)

    assert (finished.state, finished.left) == (SessionState.FINISHED, ())
    assert finished.progress.done == 3
    assert (not_begun.state, await entries(database, NOT_BEGUN)) == (SessionState.PLANNED, ())


async def test_a_killed_session_stands_where_it_was_killed(database):
    found = await stands(database, KILLED)

    assert found.state is SessionState.RUNNING
    assert (found.progress.done, found.progress.skipped) == (2, 1)
    assert [stop.config for stop in found.left] == [4, 5, 11]
    assert found.registration is not None


async def test_a_killed_session_is_taken_up_and_measures_what_is_missing(database):
    sessions = SessionRepository(database)
    cell = FakeCell()
    lines = LedgerRepository(database)
    ledger = await lines.of_session(KILLED)
    runner = TrackerRunner(await sessions.plan(KILLED), cell.cell, ledger, ledger.earlier)

    ended = await PatientOperator().attend_from_the_start(runner)

    assert ended is SessionState.FINISHED
    points = await ReadingRepository(database).points(KILLED)
    assert [point.config for point in points] == [1, 3, 4, 5, 11]
    assert (await sessions.get(KILLED)).state is SessionState.FINISHED
    assert [stop.config for stop in await sessions.skipped(KILLED)] == [2]


async def test_old_sessions_make_a_campaign(database):
    sessions, readings = SessionRepository(database), ReadingRepository(database)
    measured = [
        MeasuredSession(
            id=number,
            setup=await sessions.setup(number),
            points=tuple(await readings.points(number)),
            fixed_nests=tuple(await readings.fixed_nests(number)),
            registration=await sessions.registration(number),
        )
        for number in (FINISHED, VALIDATION)
    ]

    campaign = assemble_campaign(*measured)

    assert (len(campaign.calibration), len(campaign.validation)) == (3, 2)


async def test_a_ballbar_session_of_before_says_its_states_as_one_of_today(database):
    lines = await entries(database, AT_LUNCH)

    states = [(line.entered, line.text) for line in lines if line.entered]
    assert states == [
        (SessionState.RUNNING, "Eva started the session."),
        (SessionState.PAUSED, "Lunch: an hour."),
    ]
    assert [line.control for line in lines if line.control] == [Control.ZERO_LOST, Control.HAND_OVER]
    assert [line.kind for line in lines].count(EntryKind.MEASURED) == 1


def test_on_the_way_down_nothing_of_the_older_program_is_missing(file, tmp_path):
    tables = ("sessions", "session_states", "readings", "skipped_stops", "ballbar_entries", "events")
    before = {table: ask(file, f"SELECT * FROM {table} ORDER BY id") for table in tables}

    migrate(file, "0010", up=True)
    migrate(file, "0008", up=False)

    assert {table: ask(file, f"SELECT * FROM {table} ORDER BY id") for table in tables} == before
    assert ask(file, "PRAGMA foreign_key_check") == []
    indices = "SELECT name FROM sqlite_master WHERE name LIKE 'ix_ballbar%' ORDER BY name"
    assert [name for (name,) in ask(file, indices)] == [
        "ix_ballbar_entries_kind",
        "ix_ballbar_entries_session_id",
    ]


def test_a_database_without_sessions_gets_an_empty_ledger(tmp_path):
    file = tmp_path / "truepose.sqlite3"
    migrate(file, "0008", up=True)

    migrate(file, "head", up=True)

    assert ask(file, "SELECT count(*) FROM session_entries") == [(0,)]


def test_a_line_of_the_vector_holds_its_time_and_nothing_that_is_not_said(file):
    migrate(file, "head", up=True)

    (document,) = ask(
        file, f"SELECT document FROM session_entries WHERE session_id = {KILLED} AND kind = 'skipped'"
    )[0]
    assert json.loads(document) == {
        "step_id": "stop-2",
        "kind": "skipped",
        "time_s": 1081.5,
        "text": "no reflector near nest 1",
    }
