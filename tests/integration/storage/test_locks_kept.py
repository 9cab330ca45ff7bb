"""SQLite's locks on an open database, which go where the process closes any descriptor of its file.

Without them the next program that looks at the database takes its log for one that nobody uses and removes
it, with every commit that comes later.
"""

import asyncio
import subprocess
import sys

import pytest

from tests.helpers.storage.sessions import add, wait_until
from tests.helpers.web.clients import served, until
from tests.integration.web.bench import CELL, Bench
from truepose.settings import Settings
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.backup.restoring import lay_ready
from truepose.storage.backup.schedule import BackupSchedule, copies_in
from truepose.storage.database import Database
from truepose.storage.engine.address import database_file
from truepose.storage.errors import DatabaseInUseError
from truepose.storage.integrity.monitor import Guard

pytestmark = [
    pytest.mark.engine("sqlite"),
    pytest.mark.skipif(sys.platform == "win32", reason="only POSIX drops locks with a descriptor"),
]
LOOK = """
import sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute("SELECT count(*) FROM links").fetchone()
database.close()
"""


@pytest.fixture
async def sealed(database_url):
    """A database that a service closed in order, so that the next one compares it with its seal."""
    database = Database(database_url)
    await add(database)
    database.close()
    return database


async def log_outlives_another_program(file):
    """Whether the log of an open database is still there when another program has looked at it and gone."""
    await asyncio.to_thread(subprocess.run, [sys.executable, "-c", LOOK, str(file)], check=True)
    return file.with_name(f"{file.name}-wal").exists()


async def compare_with_the_seal(database, folder):
    await Guard(database, 0.0).check_seal()


async def look_at_everything(database, folder):
    await Guard(database, 0.0)._verify()


async def make_a_copy(database, folder):
    await BackupSchedule(database.backend.url, BackupPlan(folder / "copies")).make_if_due()


async def lay_a_copy_ready(database, folder):
    await make_a_copy(database, folder)
    ((_, copy),) = copies_in(folder / "copies")
    await asyncio.to_thread(lay_ready, copy, database.file, replace=True)


async def refuse_a_second_service(database, folder):
    with pytest.raises(DatabaseInUseError):
        Database(database.backend.url)


async def bring_it_back(database, folder):
    database.file.unlink()
    await add(database, "second")


async def begin_a_new_log(database, folder):
    database.file.with_name(f"{database.file.name}-wal").unlink()
    await add(database, "second")


WORK = [
    compare_with_the_seal,
    look_at_everything,
    make_a_copy,
    lay_a_copy_ready,
    refuse_a_second_service,
    bring_it_back,
    begin_a_new_log,
]


@pytest.mark.parametrize("work", WORK, ids=lambda work: work.__name__)
async def test_the_locks_outlast(work, sealed, database_url, tmp_path):
    database = Database(database_url)
    await add(database)

    await work(database, tmp_path)

    assert await log_outlives_another_program(database.file)
    database.close()


async def test_the_locks_outlast_everything_that_a_service_does_by_itself(sealed, database_url, tmp_path):
    (tmp_path / "cell.toml").write_text(CELL)
    plan = BackupPlan(tmp_path / "copies")
    settings = Settings(database_url, cell_file=tmp_path / "cell.toml", backups=plan)

    async with served(settings, Bench().registry()) as client:
        await until(client, "/health", lambda health: health["integrity"]["state"] == "whole")
        await wait_until(lambda: copies_in(plan.folder))

        assert await log_outlives_another_program(database_file(database_url))
