"""A server that goes, refuses or changes hands: nothing acknowledged is lost, nothing is kept twice."""

import asyncio
import os

import psycopg
import pytest

from tests.helpers.domain.tracker_sessions import make_point, make_setup, point_taken
from tests.helpers.postgresql.line import Line
from tests.helpers.postgresql.server import own_server
from tests.helpers.storage.sessions import add, names, wait_until
from truepose import health
from truepose.health import HealthMonitor
from truepose.storage.database import Database
from truepose.storage.engine.reading import require_library
from truepose.storage.errors import (
    ConflictError,
    DatabaseAddressError,
    DatabaseInUseError,
    ForeignDatabaseError,
    StorageUnavailableError,
)
from truepose.storage.integrity.verification import verify_left_at
from truepose.storage.ledger.entries import LedgerRepository

pytestmark = pytest.mark.engine("postgresql")
PATIENCE_S = 120


async def _as_soon_as_it_is_free(database_url):
    while True:
        try:
            return Database(database_url)
        except DatabaseInUseError:
            await asyncio.sleep(0.05)


@pytest.fixture
def line(server, tmp_path_factory):
    folder = tmp_path_factory.mktemp("line")
    cut = Line(server, folder)
    yield cut
    cut.close()


@pytest.fixture
def database_over_line(database_url, server, line):
    opened = Database(database_url.replace(str(server.folder), str(line.folder)))
    yield opened
    opened.close()


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("together", [1, 3])
async def test_a_commit_whose_answer_is_lost_is_acknowledged_if_it_was_made(
    database_over_line, line, when, together
):
    database = database_over_line
    await add(database)

    line.cut_next_commit(when)
    wants = [add(database, f"second {n}") for n in range(together)]
    async with asyncio.timeout(PATIENCE_S):
        results = await asyncio.gather(*wants, return_exceptions=True)
        await database.writable()
        await add(database, "last")

    kept = await names(database)
    made = [f"second {n}" for n in range(together) if not isinstance(results[n], Exception)]
    assert kept == ["first", *made, "last"]
    if together == 1:
        assert (made == []) is (when == "before")
    assert all(isinstance(one, (int, StorageUnavailableError)) for one in results)
    assert database.condition.fault is None


async def test_while_the_server_is_away_records_are_refused_and_said_to_be(database_over_line, line):
    database = database_over_line
    await add(database)
    line.cut()

    with pytest.raises(StorageUnavailableError, match=r"does not respond.*check that it is running"):
        await add(database, "second")
    with pytest.raises(StorageUnavailableError):
        await add(database, "third")
    assert "does not respond" in database.condition.fault

    line.mend()
    await asyncio.wait_for(database.writable(), PATIENCE_S)
    await add(database, "second")
    assert await names(database) == ["first", "second"]


class NoDevices:
    """A rack without devices."""

    def statuses(self):
        return []


async def test_a_server_that_is_away_does_not_have_the_service_ended(database_over_line, line, monkeypatch):
    monkeypatch.setattr("truepose.health._KEPT_S", 0.0)
    lookout = HealthMonitor(database_over_line, NoDevices(), make_setup().cell, None, lambda: 0)
    before = await lookout.state()
    line.cut()
    away = await lookout.state()
    line.mend()
    await asyncio.wait_for(database_over_line.writable(), PATIENCE_S)
    after = await lookout.state()

    assert [state.records.readable for state in (before, away, after)] == [True] * 3
    assert "does not respond" in away.records.refused
    assert (before.records.refused, after.records.refused) == ("", "")


async def test_a_server_that_is_silent_for_long_does_not_have_the_service_ended_either(database, monkeypatch):
    for name, seconds in {"_KEPT_S": 0.0, "_PATIENCE_S": 0.01, "_SILENT_S": 0.0}.items():
        monkeypatch.setattr(health, name, seconds)
    monkeypatch.setattr(health, "record_counts", lambda _database: asyncio.sleep(60))
    lookout = HealthMonitor(database, NoDevices(), make_setup().cell, None, lambda: 0)

    first, later = [(await lookout.state()).records for _ in range(2)]

    assert (first.readable, first.late, first.refused) == (True, True, "")
    assert (later.readable, "has not answered for" in later.refused) == (True, True)


async def test_who_has_lost_the_database_to_another_service_writes_nothing_any_more(
    database_over_line, line, database_url
):
    database = database_over_line
    await add(database)
    line.cut()
    async with asyncio.timeout(PATIENCE_S):
        other = await _as_soon_as_it_is_free(database_url)
    line.mend()

    with pytest.raises(StorageUnavailableError):
        await add(database, "second")
    await add(other, "theirs")
    await wait_until(lambda: "in use by another truepose service" in database.condition.fault)
    other.close()
    await wait_until(lambda: "restart this service" in database.condition.fault)

    with pytest.raises(StorageUnavailableError, match="written by another service"):
        await add(database, "second")
    assert await names(database) == ["first", "theirs"]


@pytest.mark.parametrize("when", ["before", "after"])
async def test_a_commit_in_doubt_is_answered_also_where_another_service_came_between(
    database_over_line, line, database_url, when
):
    database = database_over_line
    await add(database)
    line.closed = True  # to new connections
    line.cut_next_commit(when)
    second = asyncio.create_task(add(database, "second"))
    await wait_until(lambda: "was lost during a commit" in (database.condition.trouble or ""))
    async with asyncio.timeout(PATIENCE_S):
        other = await _as_soon_as_it_is_free(database_url)
        await add(other, "theirs")
        other.close()
        line.mend()
        await asyncio.wait({second})

    made = second.exception() is None
    assert made is (when == "after")
    assert await names(database) == ["first", *["second"] * made, "theirs"]
    with pytest.raises(StorageUnavailableError, match="written by another service"):
        await add(database, "third")


async def test_a_connection_that_the_server_ends_is_begun_anew(database, server, name):
    await add(database)
    with server.connect() as other:
        other.execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s", (name,))

    assert await names(database) == ["first"]  # a query is asked again
    await add(database, "second")  # and what was not begun is begun again

    assert await names(database) == ["first", "second"]


async def test_a_table_that_somebody_locks_holds_up_no_more_than_five_seconds(database, server, database_url):
    await add(database)
    with psycopg.connect(database_url.split("&")[0]) as other:
        other.execute("LOCK TABLE sessions")
        with pytest.raises(StorageUnavailableError, match="lock timeout"):
            await add(database, "second")
    await asyncio.wait_for(database.writable(), PATIENCE_S)
    await add(database, "second")

    assert await names(database) == ["first", "second"]


async def test_a_disk_of_the_server_that_is_full_refuses_until_there_is_room(database, database_url):
    def full(plain):
        plain.execute(
            "CREATE FUNCTION full_disk() RETURNS trigger LANGUAGE plpgsql AS "
            "$$BEGIN RAISE EXCEPTION 'No space left on device' USING ERRCODE = '53100'; END$$"
        )
        plain.execute(
            "CREATE TRIGGER full_disk BEFORE INSERT ON sessions FOR EACH ROW EXECUTE FUNCTION full_disk()"
        )

    await add(database)
    await database.on_writer(full)
    with pytest.raises(StorageUnavailableError, match=r"No space left.*disk space on the server"):
        await add(database, "second")
    await database.writable()
    await database.on_writer(lambda plain: plain.execute("DROP FUNCTION full_disk CASCADE"))
    await add(database, "second")

    assert await names(database) == ["first", "second"]


async def test_a_text_that_no_server_takes_is_refused_alone(database):
    with pytest.raises(ConflictError, match="do not allow"):
        await add(database, "nothing\0 in it")

    assert database.condition.trouble is None
    assert await add(database) == 1


async def test_numbers_have_no_gaps_behind_what_was_refused(database):
    await add(database)
    with pytest.raises(ConflictError):
        await add(database, "no\0text")
    assert await add(database, "second") == 2


@pytest.mark.parametrize("change", ["TRUNCATE notes", "DELETE FROM links", "UPDATE sessions SET name = 'x'"])
async def test_no_record_is_changed_or_thrown_away(database, change):
    await add(database)

    with pytest.raises(ConflictError, match="never changed"):
        await database.write(lambda c: c.exec_driver_sql(change))


def test_a_server_that_may_lose_what_it_acknowledged_is_refused(database_url):
    with pytest.raises(
        StorageUnavailableError, match="fsync = off: a power failure can lose acknowledged records"
    ):
        Database(database_url.replace("&fsync=off", ""))

    accepted = Database(database_url)
    assert accepted.backend.server_doubts == ("fsync", "full_page_writes", "data_checksums")
    accepted.close()


def test_commits_wait_for_the_disk_whatever_the_database_says(database_url, server):
    with server.connect() as other:
        other.execute("ALTER SYSTEM SET synchronous_commit = off")
        other.execute("SELECT pg_reload_conf()")
    try:
        database = Database(database_url)
        said = database._writer.submit(
            lambda: database.backend.plain.execute("SHOW synchronous_commit").fetchone()
        )
        assert said.result() == ("on",)
        database.close()
    finally:
        with server.connect() as other:
            other.execute("ALTER SYSTEM RESET synchronous_commit")
            other.execute("SELECT pg_reload_conf()")


def test_another_programs_database_is_refused_and_untouched(server):
    url = server.make("others", "template1")
    try:
        with server.connect("others") as other:
            other.execute("CREATE TABLE invoices (id INTEGER)")
        with pytest.raises(ForeignDatabaseError, match="another program's tables"):
            Database(url)
    finally:
        server.drop("others")


def test_a_server_that_is_not_there_is_one_sentence(tmp_path):
    with pytest.raises(StorageUnavailableError, match="does not respond"):
        Database(f"postgresql://postgres@/db?host={tmp_path}")


def test_without_the_library_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)

    with pytest.raises(DatabaseAddressError, match=r"pip install 'truepose\[postgresql\]'"):
        require_library()


def test_no_password_is_told(monkeypatch, tmp_path):
    with pytest.raises(StorageUnavailableError) as refused:
        Database(f"postgresql://ada:secret@/db?host={tmp_path}")

    assert "secret" not in str(refused.value)


async def test_a_server_that_crashes_has_kept_what_was_acknowledged(server, beside):
    with own_server() as durable:
        with durable.connect() as admin:
            admin.execute("CREATE DATABASE cell")
        database = Database(durable.url("cell"))
        number, ledger = await add(database), LedgerRepository(database)
        kept = []
        for config in range(1, 60):
            if config == 30:
                crashing = asyncio.create_task(asyncio.to_thread(durable.crash))
            while True:
                try:
                    kept.append((await ledger.append(number, point_taken(make_point(config))), config))
                    break
                except StorageUnavailableError:
                    await asyncio.wait_for(database.writable(), PATIENCE_S)
        await crashing
        rows = await database.read(
            lambda c: c.exec_driver_sql(
                "SELECT session_entries.id, config FROM readings "
                "JOIN session_entries ON reading_id = readings.id ORDER BY readings.id"
            ).all()
        )
        database.close()
        assert [tuple(row) for row in rows] == kept
        assert verify_left_at(durable.url("cell")).findings == ()


def test_a_migration_that_is_killed_leaves_nothing(server, beside):
    name = f"killed_{os.getpid()}"
    url = server.make(name, "template1")
    try:
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr("truepose.storage.engine.schema.newest_revision", _killed_after_migrating())
            with pytest.raises(KeyboardInterrupt):
                Database(url)
        with server.connect(name) as other:
            assert other.execute("SELECT count(*) FROM pg_tables WHERE schemaname = 'public'").fetchone() == (
                0,
            )
        Database(url).close()
    finally:
        server.drop(name)


def _killed_after_migrating():
    from truepose.storage.engine import schema

    asked, newest = [], schema.newest_revision

    def killed():
        asked.append(1)
        if len(asked) == 2:  # once before the migrations, once after them
            raise KeyboardInterrupt
        return newest()

    return killed


def test_every_text_of_a_server_is_compared_byte_by_byte_and_every_whole_number_has_64_bits(
    database, server, name
):
    with server.connect(name) as other:
        found = other.execute(
            "SELECT table_name, column_name, data_type, collation_name FROM information_schema.columns "
            "WHERE table_schema = 'public' AND table_name <> 'alembic_version' AND (data_type = 'integer' "
            "OR data_type = 'text' AND collation_name IS DISTINCT FROM 'C' OR data_type = 'jsonb')"
        ).fetchall()

    assert found == []
