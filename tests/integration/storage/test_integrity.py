"""What was changed behind the service's back is noticed: at the start, while it runs, and by `verify`."""

import asyncio
import os
import shutil
import sys

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.storage.sessions import add, fill, guarded, wait_until
from truepose.storage.database import Database
from truepose.storage.engine.backend import FOREIGN, Condition
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import DamagedDatabaseError, DatabaseAddressError
from truepose.storage.integrity import monitor
from truepose.storage.integrity.monitor import Guard
from truepose.storage.integrity.verification import verify_left
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.ledger.tracker_readings import ReadingRepository

pytestmark = [  # a server's: server/test_tampering.py
    pytest.mark.engine("sqlite"),
    pytest.mark.usefixtures("forked_processes"),
]
UNPROTECTED = "DROP TRIGGER readings_no_update; DROP TRIGGER readings_no_delete;"
PROTECTED = """
    CREATE TRIGGER readings_no_update BEFORE UPDATE ON readings
    BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
    CREATE TRIGGER readings_no_delete BEFORE DELETE ON readings
    BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
""".replace("\n    BEGIN", " BEGIN")
LONGER = "UPDATE readings SET document = replace(document, '101.0', '102.0') WHERE id = 3;"
MOVED = "UPDATE readings SET session_id = 2 WHERE id = 3;"
ELSEWHERE = """
    CREATE TEMP TABLE kept AS SELECT document FROM readings WHERE id = 2;
    UPDATE readings SET document = (SELECT document FROM readings WHERE id = 3) WHERE id = 2;
    UPDATE readings SET document = (SELECT document FROM kept) WHERE id = 3;
"""
REPLACED = """
    INSERT OR REPLACE INTO readings (id, recorded_at, session_id, kind, config, nest, time_s, document)
    SELECT 3, recorded_at, session_id, kind, config, nest, time_s, replace(document, '101.0', '102.0')
    FROM readings WHERE id = 3;
"""
SLIPPED_IN = """
    INSERT INTO readings (recorded_at, session_id, kind, config, nest, time_s, document)
    SELECT recorded_at, session_id, kind, 9, nest, time_s, document FROM readings WHERE id = 3;
"""
TAMPERED = {
    "a reading that is 1 mm longer": UNPROTECTED + LONGER + PROTECTED,
    "a reading taken out": UNPROTECTED + "DELETE FROM readings WHERE id = 3;" + PROTECTED,
    "the newest reading taken out": UNPROTECTED + "DELETE FROM readings WHERE id = 5;" + PROTECTED,
    "two readings exchanged": UNPROTECTED + ELSEWHERE + PROTECTED,
    "a reading of another session": UNPROTECTED
    + "UPDATE readings SET session_id = 2 WHERE id = 3;"
    + PROTECTED,
    "a reading replaced": REPLACED,
    "a reading slipped in": SLIPPED_IN,
    "a trigger dropped": "DROP TRIGGER readings_no_update;",
    "a table dropped": "PRAGMA foreign_keys = OFF; DROP TABLE notes;",
    "a link taken out": "DROP TRIGGER links_no_delete; DELETE FROM links WHERE id = 7;",
    "an event changed": "DROP TRIGGER events_no_update; UPDATE events SET document = '{}' WHERE id = 2;",
}


@pytest.fixture
async def left(database_url):
    """A database that a service closed in order."""
    database = Database(database_url)
    await fill(database)
    database.close()
    return database.file


def tamper(file, script):
    connection = LIBRARY.connect(file)
    connection.executescript(script)
    connection.close()


def without_seal(file):
    os.unlink(f"{file}.seal")
    return file


async def test_what_was_left_alone_is_whole(left, database_url):
    assert verify_left(left).findings == ()

    database = Database(database_url)
    await Guard(database, 0.0).check_seal()

    assert database.condition.fault is None
    database.close()


@pytest.mark.parametrize("script", TAMPERED.values(), ids=TAMPERED.keys())
async def test_what_was_changed_is_found_also_without_the_seal(left, script):
    tamper(without_seal(left), script)

    assert verify_left(left).findings


# What is wrong with records is found as above, in a process of its own; here, that it is begun at all.
@pytest.mark.parametrize("what", ["a reading that is 1 mm longer", "a trigger dropped", "a link taken out"])
async def test_what_is_changed_while_the_service_runs_is_found(database, what):
    await fill(database)
    async with guarded(database):
        tamper(database.file, TAMPERED[what])
        await wait_until(lambda: database.condition.fault is not None)
        await wait_until(lambda: database.condition.integrity != "checking")

    assert database.condition.integrity == "damaged"


async def test_a_doubt_that_comes_with_the_end_does_not_outlive_it(database):
    await fill(database)
    guard = Guard(database, 0.0)
    guarding = asyncio.create_task(guard.follow())
    await wait_until(lambda: database.condition.integrity == "whole")
    await asyncio.sleep(0.05)

    guarding.cancel()
    guard._doubt.set()
    async with asyncio.timeout(HANGS_S):
        await asyncio.gather(guarding, return_exceptions=True)

    assert guarding.cancelled()


async def test_what_others_write_without_changing_a_record_is_found_to_be_harmless(database, monkeypatch):
    said = noted(monkeypatch)
    await fill(database)
    async with guarded(database):
        tamper(database.file, "CREATE TABLE other (id INTEGER); DROP TABLE other;")
        await wait_until(lambda: said and database.condition.fault is None)

    assert all("Another program has written" in one for one in said)
    assert database.condition.integrity == "whole"


def noted(monkeypatch):
    """Return what is said of damage from now on, also where it is taken back at once."""
    said, note = [], Condition.note_damage

    def note_and_tell(condition, key, sentence):
        said.append(sentence)
        note(condition, key, sentence)

    monkeypatch.setattr(Condition, "note_damage", note_and_tell)
    return said


TOLD_ALL = '{"share": 1.0, "findings": [], "records": 8}'
UNFINISHED = {
    "that fails": "raise SystemExit(1)",
    "that is killed": "import os; os.kill(os.getpid(), 9)",
    "that ends before the last line": "print('{\"share\": 0.5}')",
    "that fails behind the last line": f"print('{TOLD_ALL}'); raise SystemExit(1)",
    "that says something else": f"print('a warning'); print('{TOLD_ALL}')",
    "that says a number": f"print('1'); print('{TOLD_ALL}')",
}


@pytest.mark.parametrize("process", UNFINISHED.values(), ids=UNFINISHED.keys())
async def test_a_look_by_a_process_settles_no_doubt(process, database, monkeypatch):
    monkeypatch.setattr(monitor, "_COMMAND", (sys.executable, "-c", process))
    database.condition.note_damage(FOREIGN, "Another program has written.")

    async with guarded(database, found_whole=False) as guarding:
        await wait_until(lambda: database.condition.unchecked is not None or guarding.done())

        assert not guarding.done()
        assert database.condition.damage == "Another program has written."
        assert database.condition.integrity == "damaged"


async def test_a_look_that_was_not_finished_is_taken_again(database, monkeypatch):
    looks = monitor._COMMAND
    monkeypatch.setattr(monitor, "_RETRY_S", 0.0)
    monkeypatch.setattr(monitor, "_COMMAND", (sys.executable, "-c", "raise SystemExit(1)"))
    async with guarded(database, found_whole=False):
        await wait_until(lambda: database.condition.unchecked is not None)
        monkeypatch.setattr(monitor, "_COMMAND", looks)
        await wait_until(lambda: database.condition.integrity == "whole")

    assert database.condition.unchecked is None


async def test_one_changed_bit_anywhere_shows_by_the_seal(left, database_url):
    content = bytearray(left.read_bytes())
    content[content.index(b"second")] ^= 1  # within a record: what a start reads is whole
    left.write_bytes(content)

    assert verify_left(left).findings
    database = Database(database_url)
    await Guard(database, 0.0).check_seal()
    assert "was changed while no service had it open" in database.condition.fault
    database.close()


async def test_an_older_copy_with_less_in_it_is_noticed_at_the_start(left, database_url):
    shutil.copy(left, left.with_name("older"))
    database = Database(database_url)
    await add(database, "third")
    database.close()
    shutil.copy(left.with_name("older"), left)

    database = Database(database_url)

    assert "The newest records" in database.condition.fault
    database.close()


async def test_a_log_that_was_cut_after_a_kill_is_noticed_at_the_start(database, tmp_path):
    await fill(database)
    for ending in ("", "-wal", ".seal"):  # as a kill leaves it
        shutil.copy(f"{database.file}{ending}", tmp_path / f"killed{ending}")
    log = tmp_path / "killed-wal"
    log.write_bytes(log.read_bytes()[:-3000])

    opened = Database(f"sqlite:///{tmp_path}/killed")

    assert "The newest records" in opened.condition.fault
    opened.close()


async def test_the_readings_of_a_session_are_not_used_where_one_was_changed(database):
    await fill(database)
    sessions = SessionRepository(database)
    await sessions.require_intact(1)

    tamper(database.file, TAMPERED["a reading that is 1 mm longer"])

    with pytest.raises(
        DamagedDatabaseError, match="Record 3 of the readings of session 1 differs from what was written"
    ):
        await sessions.require_intact(1)
    await sessions.require_intact(2)


async def test_a_document_that_cannot_be_read_is_damage_and_no_fault_of_the_program(database):
    await fill(database)
    tamper(database.file, UNPROTECTED + "UPDATE readings SET document = '{\"x' WHERE id = 3;")

    with pytest.raises(DamagedDatabaseError, match="cannot be read"):
        await ReadingRepository(database).get(3)
    with pytest.raises(DamagedDatabaseError):
        await ReadingRepository(database).points(1)


async def test_a_damaged_page_is_damage(left, database_url):
    content = bytearray(left.read_bytes())
    content[4096:] = os.urandom(len(content) - 4096)
    left.write_bytes(content)

    with pytest.raises(DamagedDatabaseError, match="damaged"):
        Database(database_url)
    assert verify_left(left).findings


async def test_a_header_that_is_spoiled_while_the_service_runs_is_damage(database):
    await fill(database)
    await database.on_writer(lambda plain: plain.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone())
    with database.file.open("rb+") as file:
        file.write(b"\xff" * 100)

    with pytest.raises(DamagedDatabaseError, match="not a database"):
        await ReadingRepository(database).get(3)
    assert database.condition.damaged


def test_a_database_that_is_not_there_cannot_be_verified(tmp_path):
    with pytest.raises(DatabaseAddressError, match="no database"):
        verify_left(tmp_path / "nothing.sqlite3")


async def test_replacing_a_record_is_refused_by_our_own_connection(database):
    await fill(database)

    with pytest.raises(Exception, match="never changed"):
        await database.write(lambda c: c.exec_driver_sql(REPLACED.strip().rstrip(";")))


@pytest.mark.skipif(sys.platform == "win32", reason="removing an open file is POSIX")
async def test_a_removed_database_comes_back_without_anybody_writing(database):
    await fill(database)
    async with guarded(database):
        database.file.unlink()
        await wait_until(database.file.exists)

        assert verify_left(database.file).head == await database.head()


async def test_another_file_in_its_place_is_no_damage_of_the_database(database):
    await fill(database)
    database.file.rename(database.file.with_name("away"))
    database.file.write_text("something else")

    async with guarded(database, found_whole=False):
        await wait_until(lambda: "Another file lies" in (database.condition.fault or ""))
        await asyncio.sleep(1.0)
        assert not database.condition.damaged

        database.file.with_name("away").replace(database.file)
        await wait_until(lambda: database.condition.fault is None)
