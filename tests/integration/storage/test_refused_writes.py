"""Writes that the disk refuses: each is answered, none is lost, and writing goes on when it can."""

import asyncio
import os
import shutil
import subprocess
import sys
import textwrap

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.storage.sessions import add, names
from truepose.storage.database import Database
from truepose.storage.engine import sqlite_file
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import ConflictError, StorageUnavailableError

pytestmark = pytest.mark.engine("sqlite")  # a server's refusals: server/test_refusals.py


def pragma(database, statement):
    """Ask the library of the writer for something, or have it set."""
    return database._writer.submit(
        lambda: database.backend.plain.execute(f"PRAGMA {statement}").fetchone()
    ).result()


@pytest.fixture
def impatient(database):
    """The same database, whose writer does not wait for a lock."""
    pragma(database, "busy_timeout=0")
    return database


@pytest.fixture
def locked(impatient):
    other = LIBRARY.connect(impatient.file, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    yield other
    other.close()


async def test_a_lock_that_others_hold_refuses_until_it_is_gone(impatient, locked):
    with pytest.raises(StorageUnavailableError, match="locked"):
        await add(impatient)
    assert "locked" in impatient.condition.fault
    with pytest.raises(StorageUnavailableError, match="locked"):
        await add(impatient)

    locked.execute("ROLLBACK")
    await asyncio.wait_for(impatient.writable(), HANGS_S)
    await add(impatient)

    assert impatient.condition.fault is None
    assert await names(impatient) == ["first"]


async def test_a_full_disk_refuses_until_there_is_room(database):
    (full,) = pragma(database, "page_count")
    pragma(database, f"max_page_count={full}")
    with pytest.raises(StorageUnavailableError, match="full"):
        for _ in range(50):
            await add(database, "too many")
    kept = await names(database)

    pragma(database, f"max_page_count={2**31}")
    await asyncio.wait_for(database.writable(), HANGS_S)
    await add(database, "last")

    assert await names(database) == [*kept, "last"]


@pytest.mark.parametrize("others", [0, 3])
async def test_a_link_for_which_there_is_no_room_is_refused_like_any_record(database, others):
    def linked(connection):
        link = (
            "INSERT INTO links (stream, record, record_id, hash) VALUES (0, 'sessions', 1, zeroblob(100000))"
        )
        connection.connection.cursor().execute(link)

    (full,) = pragma(database, "page_count")
    pragma(database, f"max_page_count={full + 10}")
    wants = [add(database, f"number {n}") for n in range(others)]
    *results, refused = await asyncio.gather(*wants, database.write(linked), return_exceptions=True)

    assert isinstance(refused, StorageUnavailableError), refused
    assert results == [*range(1, others + 1)]
    await asyncio.wait_for(database.writable(), HANGS_S)
    await add(database, "last")


@pytest.mark.engine("sqlite", "postgresql")
async def test_writes_that_come_together_share_a_commit_and_fail_alone(database):
    def refused(connection):
        connection.exec_driver_sql("UPDATE sessions SET name = 'other'")

    def half_way(connection):
        connection.exec_driver_sql(
            "INSERT INTO notes (id, recorded_at, session_id, text) VALUES (1, '', 1, 'half')"
        )
        raise ValueError("half way")

    await add(database)
    wants = [add(database, f"number {n}") for n in range(10)]
    wants[5:5] = [database.write(refused), database.write(half_way)]
    commits = []
    database.commits.told = commits.append
    results = await asyncio.gather(*wants, return_exceptions=True)

    assert len(commits) <= 2  # the first may have gone ahead
    results += [results.pop(5), results.pop(5)]
    assert isinstance(results[-2], ConflictError)
    assert isinstance(results[-1], ValueError)
    assert sorted(results[:10]) == [*range(2, 12)]
    assert await database.read(lambda c: c.exec_driver_sql("SELECT count(*) FROM notes").scalar()) == 0


@pytest.mark.parametrize("also", [(), ("-wal", "-shm"), ("-wal",)])
async def test_a_database_that_is_removed_is_written_anew_with_everything_in_it(database, also):
    await add(database)
    for ending in ("", *also):
        os.unlink(f"{database.file}{ending}")

    await add(database, "second")

    assert await names(database) == ["first", "second"]
    with LIBRARY.connect(database.file) as other:
        assert [name for (name,) in other.execute("SELECT name FROM sessions")] == ["first", "second"]
        assert other.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    other.close()


async def test_a_database_that_is_removed_before_the_service_ends_is_left_at_its_place(database_url):
    database = Database(database_url)
    await add(database)
    database.file.unlink()
    database.close()

    database = Database(database_url)
    assert await names(database) == ["first"]
    assert database.condition.fault is None
    database.close()


async def test_a_folder_that_is_removed_is_made_anew(database):
    await add(database)
    shutil.rmtree(database.file.parent)

    await add(database, "second")

    assert await names(database) == ["first", "second"]


async def test_a_log_that_is_removed_is_begun_anew_and_nothing_hangs_on_it(database, database_url):
    await add(database)
    os.unlink(f"{database.file}-wal")
    await add(database, "second")

    for ending in ("", "-wal"):  # as a power cut leaves it
        shutil.copy(f"{database.file}{ending}", f"{database.file.parent}/copy{ending}")
    copy = Database(f"sqlite:///{database.file.parent}/copy")
    assert await names(copy) == ["first", "second"]
    copy.close()


async def test_a_database_in_whose_place_another_file_lies_is_not_written_over_it(database):
    await add(database)
    database.file.rename(database.file.with_name("away"))
    database.file.write_text("something else")

    with pytest.raises(StorageUnavailableError, match="Another file lies at"):
        await add(database, "second")
    assert database.file.read_text() == "something else"
    database.file.unlink()
    await asyncio.wait_for(database.writable(), HANGS_S)
    await add(database, "second")

    assert await names(database) == ["first", "second"]


def put_something(database):
    database.file.write_text("something else")
    database.file.with_name(f"{database.file.name}-wal").write_text("its log")


def put_it_back(database):
    database.file.with_name("away").rename(database.file)


@pytest.mark.parametrize(("put", "others"), [(put_something, True), (put_it_back, False)])
async def test_what_somebody_puts_there_while_it_is_written_anew_stays(database, monkeypatch, put, others):
    copied = sqlite_file._copy

    def copied_while_somebody_acts(connection, target):
        copied(connection, target)
        put(database)

    await add(database)
    content = database.file.read_bytes()
    log = database.file.with_name(f"{database.file.name}-wal")
    logged = log.read_bytes()
    database.file.rename(database.file.with_name("away"))
    with monkeypatch.context() as slow:
        slow.setattr(sqlite_file, "_copy", copied_while_somebody_acts)
        with pytest.raises(StorageUnavailableError):
            await add(database, "second")

    found = (database.file.read_bytes(), log.read_bytes())
    assert found == ((b"something else", b"its log") if others else (content, logged))
    if others:
        database.file.unlink()
    await asyncio.wait_for(database.writable(), 10)
    await add(database, "second")
    assert await names(database) == ["first", "second"]


OPENS = "import sys; from truepose.storage.database import Database; Database(sys.argv[1])"


def open_elsewhere(url):
    return subprocess.run([sys.executable, "-c", OPENS, url], capture_output=True, text=True, check=False)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere the side file alone keeps others off")
async def test_a_second_service_is_kept_off_by_whatever_way_it_comes(database, tmp_path):
    (tmp_path / "elsewhere").mkdir()
    os.link(database.file, tmp_path / "elsewhere/hard.sqlite3")
    os.symlink(database.file, tmp_path / "elsewhere/soft.sqlite3")
    os.unlink(f"{database.file}.lock")

    for path in (database.file, tmp_path / "elsewhere/hard.sqlite3", tmp_path / "elsewhere/soft.sqlite3"):
        assert "DatabaseInUseError" in open_elsewhere(f"sqlite:///{path}").stderr, path


async def test_a_database_that_was_written_anew_is_locked_as_well(database):
    await add(database)
    database.file.unlink()
    await add(database, "second")
    os.unlink(f"{database.file}.lock")

    assert "DatabaseInUseError" in open_elsewhere(f"sqlite:///{database.file}").stderr


FILLS = textwrap.dedent("""
    import asyncio, resource, sys
    from truepose.storage.database import Database
    from truepose.storage.errors import StorageUnavailableError
    from truepose.storage.ledger.sessions import SessionRepository
    from tests.helpers.domain.tracker_sessions import make_plan, make_setup

    async def main():
        database = Database(sys.argv[1])
        sessions = SessionRepository(database)
        kept = []
        resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, -1))
        try:
            while True:
                kept.append(await sessions.add("s", make_setup(), make_plan()))
        except StorageUnavailableError:
            resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))
        await database.writable()
        kept.append(await sessions.add("s", make_setup(), make_plan()))
        found = await database.read(lambda c: list(c.exec_driver_sql("SELECT id FROM sessions").scalars()))
        print(len(kept) > 3 and kept == found)

    asyncio.run(main())
""")


@pytest.mark.skipif(sys.platform == "win32", reason="limits of the size of files are POSIX")
def test_a_disk_that_takes_no_more_bytes_loses_nothing(database_url):
    done = subprocess.run(
        [sys.executable, "-c", FILLS, database_url], capture_output=True, text=True, check=False
    )

    assert done.stdout == "True\n", done.stderr
