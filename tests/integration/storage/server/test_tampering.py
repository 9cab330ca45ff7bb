"""What was changed on a server behind the service's back is noticed: at the start, meanwhile, by `verify`."""

import pytest

from tests.helpers.storage.sessions import fill, guarded, wait_until
from truepose.storage.database import Database
from truepose.storage.errors import DamagedDatabaseError
from truepose.storage.integrity.verification import verify_left_at
from truepose.storage.ledger.sessions import SessionRepository

pytestmark = [pytest.mark.engine("postgresql"), pytest.mark.usefixtures("forked_processes")]
UNPROTECTED = "ALTER TABLE readings DISABLE TRIGGER USER;"
PROTECTED = "ALTER TABLE readings ENABLE TRIGGER USER;"
DETACHED = "ALTER TABLE readings DISABLE TRIGGER ALL;"
ATTACHED = "ALTER TABLE readings ENABLE TRIGGER ALL;"
LONGER = "UPDATE readings SET document = replace(document::text, '101.0', '102.0')::json WHERE id = 3;"
TAMPERED = {
    "a reading that is 1 mm longer": UNPROTECTED + LONGER + PROTECTED,
    "a reading taken out": DETACHED + "DELETE FROM readings WHERE id = 3;" + ATTACHED,
    "the newest reading taken out": DETACHED + "DELETE FROM readings WHERE id = 5;" + ATTACHED,
    "a reading of another session": UNPROTECTED
    + "UPDATE readings SET session_id = 2 WHERE id = 3;"
    + PROTECTED,
    "a reading slipped in": """
        INSERT INTO readings (id, recorded_at, session_id, kind, config, nest, time_s, document)
        SELECT 6, recorded_at, session_id, kind, 9, nest, time_s, document FROM readings WHERE id = 3;
    """,
    "a trigger dropped": "DROP TRIGGER readings_no_update ON readings;",
    "a trigger put out of force": "ALTER TABLE readings DISABLE TRIGGER readings_no_delete;",
    "a trigger that refuses nothing": """
        CREATE OR REPLACE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql
        AS 'BEGIN RETURN NEW; END';
    """,
    "a table dropped": "DROP TABLE notes;",
    "a link taken out": "ALTER TABLE links DISABLE TRIGGER USER; DELETE FROM links WHERE id = 7;",
    "the same text in other letters": UNPROTECTED
    + "UPDATE readings SET document = replace(document::text, ', ', ',')::json WHERE id = 2;"
    + PROTECTED,
}


@pytest.fixture
async def left(database_url):
    """A database that a service closed in order."""
    database = Database(database_url)
    await fill(database)
    database.close()
    return database


@pytest.fixture
def tamper(server, name):
    """Return what changes the database behind the service's back."""

    def changed(script):
        with server.connect(name) as connection:
            connection.execute(script)

    return changed


@pytest.mark.parametrize("script", TAMPERED.values(), ids=TAMPERED.keys())
async def test_what_was_changed_is_found(left, tamper, database_url, script):
    assert verify_left_at(database_url).findings == ()

    tamper(script)

    assert verify_left_at(database_url).findings


async def test_a_trigger_that_is_put_out_of_force_while_the_service_runs_is_found(database, tamper):
    await fill(database)
    async with guarded(database):
        tamper(TAMPERED["a trigger put out of force"])
        await wait_until(lambda: database.condition.fault is not None)

    assert "trigger" in database.condition.fault


async def test_records_that_another_program_writes_bring_a_verification(database, tamper, database_url):
    await fill(database)
    async with guarded(database):
        tamper("INSERT INTO links SELECT max(id) + 1, 0, 'sessions', 9, 'x' FROM links")
        await wait_until(lambda: "Another program has written" in (database.condition.fault or ""))
        await wait_until(lambda: database.condition.integrity == "damaged")

    assert verify_left_at(database_url).findings


async def test_a_server_that_comes_back_with_less_is_noticed_at_the_start(left, tamper, database_url):
    tamper("ALTER TABLE links DISABLE TRIGGER USER; DELETE FROM links WHERE id > 10;")
    tamper("ALTER TABLE links ENABLE TRIGGER USER;")

    database = Database(database_url)

    assert "The newest records" in database.condition.fault
    database.close()


async def test_the_readings_of_a_session_are_not_used_where_one_was_changed(database, tamper):
    await fill(database)
    sessions = SessionRepository(database)
    await sessions.require_intact(1)

    tamper(TAMPERED["a reading that is 1 mm longer"])

    with pytest.raises(
        DamagedDatabaseError, match="Record 3 of the readings of session 1 differs from what was written"
    ):
        await sessions.require_intact(1)
    await sessions.require_intact(2)
