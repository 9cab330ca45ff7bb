"""What was changed on a server behind the service's back is noticed: at the start, meanwhile, by `verify`."""

import asyncio

import pytest

from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.helpers.machine import HANGS_S
from truepose.storage.database import Database
from truepose.storage.errors import DamagedDatabaseError
from truepose.storage.integrity.monitor import Guard
from truepose.storage.integrity.verification import verify_left_at
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository

pytestmark = pytest.mark.engine("postgresql")
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


async def fill(database):
    sessions, ledger = SessionRepository(database), LedgerRepository(database)
    for name in ("first", "second"):
        await sessions.add(name, make_setup(), make_plan())
    for config in range(1, 6):
        await ledger.append(1, point_taken(make_point(config)))


@pytest.fixture
async def left(database_url):
    """A database that a service closed in order."""
    database = Database(database_url)
    await fill(database)
    database.close()
    return database


def tamper(server, url, script):
    with server.connect(url.split("/")[3].split("?")[0]) as connection:
        connection.execute(script)


@pytest.mark.parametrize("script", TAMPERED.values(), ids=TAMPERED.keys())
async def test_what_was_changed_is_found(left, server, database_url, script):
    assert verify_left_at(database_url).findings == ()

    tamper(server, database_url, script)

    assert verify_left_at(database_url).findings


async def whole(database):
    async with asyncio.timeout(HANGS_S):
        while database.condition.integrity != "whole":
            await asyncio.sleep(0.05)


async def test_a_trigger_that_is_put_out_of_force_while_the_service_runs_is_found(
    database, server, database_url
):
    await fill(database)
    guarding = asyncio.create_task(Guard(database, 0.0).follow())
    await whole(database)

    tamper(server, database_url, TAMPERED["a trigger put out of force"])
    async with asyncio.timeout(HANGS_S):
        while database.condition.fault is None:
            await asyncio.sleep(0.05)

    assert "trigger" in database.condition.fault
    guarding.cancel()
    await asyncio.gather(guarding, return_exceptions=True)


async def test_records_that_another_program_writes_bring_a_verification(database, server, database_url):
    await fill(database)
    guarding = asyncio.create_task(Guard(database, 0.0).follow())
    await whole(database)

    link = "INSERT INTO links SELECT max(id) + 1, 0, 'sessions', 9, 'x' FROM links"
    tamper(server, database_url, link)
    async with asyncio.timeout(HANGS_S):
        while "Another program has written" not in (database.condition.fault or ""):
            await asyncio.sleep(0.05)
        while database.condition.integrity != "damaged":
            await asyncio.sleep(0.05)

    assert verify_left_at(database_url).findings
    guarding.cancel()
    await asyncio.gather(guarding, return_exceptions=True)


async def test_a_server_that_comes_back_with_less_is_noticed_at_the_start(left, server, database_url):
    tamper(server, database_url, "ALTER TABLE links DISABLE TRIGGER USER; DELETE FROM links WHERE id > 10;")
    tamper(server, database_url, "ALTER TABLE links ENABLE TRIGGER USER;")

    database = Database(database_url)

    assert "The newest records" in database.condition.fault
    database.close()


async def test_the_readings_of_a_session_are_not_used_where_one_was_changed(database, server, database_url):
    await fill(database)
    sessions = SessionRepository(database)
    await sessions.require_intact(1)

    tamper(server, database_url, TAMPERED["a reading that is 1 mm longer"])

    with pytest.raises(DamagedDatabaseError, match="Record 3 of the readings of session 1 is not as it was"):
        await sessions.require_intact(1)
    await sessions.require_intact(2)
