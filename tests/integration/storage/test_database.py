"""The database keeps what it acknowledged, has one owner, and knows its schema."""

import subprocess
import sys
import textwrap
from contextlib import closing

import pytest
from sqlalchemy import text

from truepose.storage.database import Database
from truepose.storage.engine.address import display_address
from truepose.storage.engine.reading import open_reader
from truepose.storage.engine.schema import newest_revision
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import (
    DatabaseAddressError,
    DatabaseInUseError,
    ForeignDatabaseError,
    NewerSchemaError,
    StorageUnavailableError,
)
from truepose.storage.tables import metadata

WRITES_UNTIL_KILLED = textwrap.dedent("""
    import asyncio, sys
    from truepose.storage.database import Database
    from truepose.storage.ledger.entries import LedgerRepository
    from truepose.storage.ledger.sessions import SessionRepository
    from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken

    async def main():
        database = Database(sys.argv[1])
        sessions, ledger = SessionRepository(database), LedgerRepository(database)
        number = await sessions.add("crash", make_setup(), make_plan())
        for config in range(1, 100_000):
            print(await ledger.append(number, point_taken(make_point(config))), flush=True)

    asyncio.run(main())
""")

NEWER = "UPDATE alembic_version SET version_num = '9999'"


def test_a_killed_service_has_kept_every_reading_that_it_acknowledged(database_url):
    with subprocess.Popen(
        [sys.executable, "-c", WRITES_UNTIL_KILLED, database_url], stdout=subprocess.PIPE, text=True
    ) as writer:
        acknowledged = [int(writer.stdout.readline()) for _ in range(50)]
        writer.kill()
        acknowledged += [int(line) for line in writer.stdout if line.endswith("\n")]

    database = Database(database_url)  # the lock went with the process
    with closing(open_reader(database_url)) as connection:
        kept = [number for (number,) in connection.execute("SELECT id FROM readings ORDER BY id")]
    database.close()

    # One more may be on disk: committed, and the process died before it could say so.
    assert acknowledged == kept[: len(acknowledged)]
    assert len(kept) - len(acknowledged) <= 1


@pytest.mark.engine("sqlite")
def test_commits_wait_for_the_disk(database):
    def pragmas(connection):
        names = ("synchronous", "journal_mode", "foreign_keys", "busy_timeout")
        return [connection.exec_driver_sql(f"PRAGMA {name}").scalar() for name in names]

    found = database._writer.submit(database._write, pragmas).result()

    assert found == [2, "wal", 1, 5000]  # 2 is FULL


async def test_a_query_cannot_write(database):
    with pytest.raises(StorageUnavailableError, match=r"read-?only"):
        await database.read(lambda c: c.execute(text("DELETE FROM events")))


async def test_a_failing_transaction_leaves_nothing(database):
    def work(connection):
        connection.execute(
            text("INSERT INTO events (id, recorded_at, kind, document) VALUES (1, '', '', '{}')")
        )
        raise ValueError("half way")

    with pytest.raises(ValueError, match="half way"):
        await database.write(work)

    assert await database.read(lambda c: c.execute(text("SELECT * FROM events")).all()) == []


def test_a_second_service_on_the_same_database_is_refused(database, database_url):
    with pytest.raises(DatabaseInUseError, match="in use by another truepose service; stop that one"):
        Database(database_url)


def test_a_second_service_in_another_process_is_refused(database, database_url):
    script = f"from truepose.storage.database import Database; Database({database_url!r})"

    second = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)

    assert "DatabaseInUseError" in second.stderr


def test_a_database_let_go_can_be_opened_again(database_url):
    first, second = (_opened_and_closed(database_url) for _ in range(2))

    assert first == second == newest_revision()


def _opened_and_closed(url):
    database = Database(url)
    database.close()
    return database.schema


def test_a_newer_schema_is_refused_with_a_sentence(database_url):
    opened = Database(database_url)
    opened._writer.submit(lambda: opened.backend.plain.execute(NEWER)).result()
    opened.close()

    with pytest.raises(NewerSchemaError, match="has schema 9999, this version of truepose knows up to"):
        Database(database_url)

    with pytest.raises(NewerSchemaError):  # and the refusal let go of the lock
        Database(database_url)


def test_a_file_that_is_no_database_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("no database at all, " * 100)

    with pytest.raises(ForeignDatabaseError, match="is not a SQLite database"):
        Database(f"sqlite:///{tmp_path}/notes.txt")


def test_another_programs_database_is_refused_and_untouched(tmp_path):
    with LIBRARY.connect(tmp_path / "other.db") as connection:
        connection.execute("CREATE TABLE invoices (id INTEGER)")
    connection.close()

    with pytest.raises(ForeignDatabaseError, match="another program's tables"):
        Database(f"sqlite:///{tmp_path}/other.db")

    with LIBRARY.connect(tmp_path / "other.db") as connection:
        tables = connection.execute("SELECT name FROM sqlite_master").fetchall()
    connection.close()
    assert tables == [("invoices",)]


@pytest.mark.parametrize(
    "url", ["mysql://host/db", "sqlite://", "sqlite:///:memory:", "truepose.db", "postgresql://"]
)
def test_what_is_no_database_of_ours_is_refused(url):
    with pytest.raises(DatabaseAddressError, match="write sqlite:///"):
        Database(url)


@pytest.mark.parametrize(
    "url",
    [
        "postgresql//ada:se/cret@host/db",
        "postgresql://ada:secret@host:port/db",
        "postgresql://host:port/db?password=secret",
        "mysql://ada:secret@host/db?password=secret",
    ],
)
def test_a_password_in_what_is_no_database_is_not_said(url):
    with pytest.raises(DatabaseAddressError, match="write sqlite:///") as raised:
        Database(url)

    assert "cret" not in str(raised.value)


@pytest.mark.parametrize("scheme", ["postgresql", "postgres", "postgresql+psycopg"])
def test_a_server_is_the_same_by_each_name_of_its_kind(scheme):
    assert display_address(f"{scheme}://ada:secret@host/db") == "postgresql://ada@host/db"


def test_a_socket_may_stand_in_the_place_of_the_host():
    shown = display_address("postgresql://ada:secret@%2Frun%2Fpg:5433/db")

    assert shown == display_address("postgresql://ada:secret@:5433/db?host=/run/pg")


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")

    with pytest.raises(StorageUnavailableError, match="cannot be written"):
        Database(f"sqlite:///{tmp_path}/file/truepose.sqlite3")


@pytest.mark.engine("sqlite")
def test_every_table_is_append_only(database):
    with LIBRARY.connect(database.file) as connection:
        triggers = {
            name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type='trigger'")
        }
    connection.close()

    assert triggers == {
        f"{table}_no_{action}" for table in metadata.tables for action in ("update", "delete")
    }


def test_a_database_of_the_newest_schema_is_opened_without_migrations(database_url, monkeypatch):
    Database(database_url).close()
    monkeypatch.setattr("truepose.storage.engine.schema.upgrade", None)

    again = Database(database_url)
    again.close()

    assert again.schema == newest_revision()


def test_who_verifies_a_database_loads_nothing_that_migrates():
    script = "import sys, truepose.storage.integrity.verification; print('alembic' in sys.modules)"

    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)

    assert found.stdout.strip() == "False"
