"""Nobody but the owner reads what a service keeps: database, log, lock, seal, copies; whatever the umask."""

import logging
import os
import stat

import pytest

from tests.helpers.machine import POSIX_MODES
from truepose.app.logs import logged
from truepose.storage.backup.plan import BackupPlan
from truepose.storage.backup.schedule import BackupSchedule, back_up_at, restore_at
from truepose.storage.database import Database

pytestmark = [
    pytest.mark.engine("sqlite"),
    POSIX_MODES,
]


@pytest.fixture(autouse=True)
def open_umask():
    """Whatever is made is everybody's, unless somebody takes care."""
    before = os.umask(0)
    yield
    os.umask(before)


def readable(folder):
    """Return the names of the files that others than the owner can do anything with."""
    files = [file for file in folder.rglob("*") if file.is_file()]
    assert files
    return sorted(file.name for file in files if stat.S_IMODE(file.stat().st_mode) & 0o077)


async def written(url):
    database = Database(url)
    await database.write_a_trial()
    await database.keep_reserve()
    return database


async def test_what_lies_beside_an_open_database_is_its_owners_alone(database_url, tmp_path):
    database = await written(database_url)
    names = {file.name.removeprefix("truepose.sqlite3") for file in tmp_path.iterdir()}
    found = readable(tmp_path)
    database.close()

    assert {"", "-wal", "-shm", ".lock", ".seal", ".reserve"} <= names
    assert found == readable(tmp_path) == []


async def test_what_an_older_version_left_readable_is_so_no_more(database_url, tmp_path):
    database = await written(database_url)
    database.close()
    for name in ("", "-wal", "-shm", ".lock", ".seal"):
        (tmp_path / f"truepose.sqlite3{name}").touch()
        (tmp_path / f"truepose.sqlite3{name}").chmod(0o644)

    database = await written(database_url)
    found = readable(tmp_path)
    database.close()

    assert found == []


async def test_copies_are_their_owners_alone(database_url, tmp_path):
    database = await written(database_url)
    folder = tmp_path / "copies"
    back_up_at(database_url, folder / "copy.sqlite3")
    schedule = BackupSchedule(database_url, BackupPlan(folder))
    await schedule.make_if_due()
    database.close()
    restore_at(folder / "copy.sqlite3", f"sqlite:///{tmp_path}/restored.sqlite3")

    assert len(list(folder.iterdir())) == 2
    assert readable(tmp_path) == []


def test_the_log_is_its_owners_alone(tmp_path):
    log = tmp_path / "truepose.log"
    for name in ("", ".1", ".5"):
        (tmp_path / f"truepose.log{name}").write_text("of an older version\n")

    with logged(log, "INFO"):
        logging.getLogger("a test").info("who was signed in")

    assert "who was signed in" in log.read_text()
    assert readable(tmp_path) == []
