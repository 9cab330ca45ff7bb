"""Copies of a database: whole, of what was acknowledged, and put back without losing what was there."""

import asyncio
import json
import os
import zipfile

import pytest

from tests.helpers.commands import installed
from tests.helpers.domain.tracker_sessions import make_point, point_taken
from tests.helpers.storage.sessions import add
from tests.helpers.web.clients import served
from tests.integration.web.bench import CELL, Bench
from truepose.settings import Settings
from truepose.storage.backup import copying
from truepose.storage.backup.copying import back_up, drafts_beside, restore_drafts
from truepose.storage.backup.restoring import lay_ready, put_ready_in_place, restore
from truepose.storage.backup.transfer import transfer
from truepose.storage.database import Database
from truepose.storage.drafts import DraftFolder
from truepose.storage.engine.sqlite_connections import LIBRARY
from truepose.storage.errors import BackupError, DatabaseAddressError, DatabaseInUseError, DatabaseUsedError
from truepose.storage.integrity.database_identity import IdentityFile
from truepose.storage.integrity.verification import verify_left
from truepose.storage.ledger.entries import LedgerRepository

pytestmark = pytest.mark.engine("sqlite")  # of a server's: server/test_copies.py


def names(file):
    connection = LIBRARY.connect(file)
    try:
        return [name for (name,) in connection.execute("SELECT name FROM sessions ORDER BY id")]
    finally:
        connection.close()


@pytest.fixture
def copy(tmp_path):
    return tmp_path / "copies" / "copy.sqlite3"


async def test_a_copy_of_a_database_in_use_holds_all_that_was_acknowledged(database, copy):
    await add(database, "first")
    head = await database.head()

    made = await asyncio.to_thread(back_up, database.file, copy)

    assert made.head == head
    assert made.size_bytes == copy.stat().st_size
    assert [path.name for path in copy.parent.iterdir()] == ["copy.sqlite3"]
    verdict = verify_left(copy)
    assert (verdict.findings, verdict.head) == ((), head)


async def test_a_copy_under_load_is_a_prefix_in_the_order_of_the_acknowledgements(database, copy):
    session, ledger = await add(database, "busy"), LedgerRepository(database)
    acknowledged = []

    async def measure():
        for config in range(1, 200):
            await ledger.append(session, point_taken(make_point(config)))
            acknowledged.append(config)

    measuring = asyncio.create_task(measure())
    while len(acknowledged) < 5:
        await asyncio.sleep(0)
    before = len(acknowledged)
    await asyncio.to_thread(back_up, database.file, copy)
    measuring.cancel()
    await asyncio.gather(measuring, return_exceptions=True)

    with LIBRARY.connect(copy) as copied:
        held = [config for (config,) in copied.execute("SELECT config FROM readings ORDER BY id")]
    copied.close()
    assert held == [*range(1, len(held) + 1)]
    assert len(held) >= before
    assert verify_left(copy).findings == ()


async def test_a_copy_that_the_disk_spoils_is_not_kept(database, copy, monkeypatch):
    await add(database, "first")
    written = copying.copy_database

    def spoilt(source, target, told):
        head = written(source, target, told)
        with target.open("rb+") as file:
            file.seek(4096)
            file.write(os.urandom(4096))
        return head

    monkeypatch.setattr(copying, "copy_database", spoilt)

    with pytest.raises(BackupError, match=r"cannot be copied|differs from the database"):
        await asyncio.to_thread(back_up, database.file, copy)
    assert [*copy.parent.iterdir()] == []


async def test_a_copy_takes_the_place_of_nothing_unasked(database, copy):
    await add(database, "first")
    await asyncio.to_thread(back_up, database.file, copy)
    await add(database, "second")

    with pytest.raises(BackupError, match="already exists"):
        back_up(database.file, copy)
    assert names(copy) == ["first"]
    with pytest.raises(BackupError, match="already exists"):
        back_up(database.file, database.file, replace=True)

    back_up(database.file, copy, replace=True)
    assert names(copy) == ["first", "second"]


def test_nothing_is_copied_of_a_database_that_is_not_there(tmp_path, copy):
    with pytest.raises(DatabaseAddressError, match="no database"):
        back_up(tmp_path / "none", copy)
    assert not copy.parent.exists()


@pytest.fixture
async def left(database_url, copy):
    """A database with a session more than its copy, which a service closed in order."""
    database = Database(database_url)
    await add(database, "first")
    back_up(database.file, copy)
    await add(database, "second")
    database.close()
    return database.file


def test_a_copy_is_restored_where_there_is_nothing(left, copy, tmp_path):
    head, kept = restore(copy, tmp_path / "fresh" / "cell.sqlite3")

    assert kept is None
    assert names(tmp_path / "fresh" / "cell.sqlite3") == ["first"]
    assert verify_left(tmp_path / "fresh" / "cell.sqlite3").head == head


def test_a_used_database_is_not_overwritten_unasked(left, copy):
    with pytest.raises(DatabaseUsedError, match="already contains records"):
        restore(copy, left)

    assert names(left) == ["first", "second"]


def test_what_is_replaced_is_kept_with_all_that_was_in_it(left, copy, database_url):
    _, kept = restore(copy, left, replace=True)

    assert names(left) == ["first"]
    assert names(kept) == ["first", "second"]
    assert verify_left(kept).findings == ()
    database = Database(database_url)  # nobody misses the newest records: they were put aside on purpose
    assert database.condition.fault is None
    database.close()


def with_a_spoiled_header(content):
    return b"\xff" * 100 + content[100:]


def with_a_spoiled_page(content):
    return content[:100] + b"\xff" * 3996 + content[4096:]


def cut_within_a_page(content):
    return content[:5000]


DAMAGE = [with_a_spoiled_header, with_a_spoiled_page, cut_within_a_page]


@pytest.mark.parametrize("damaged", DAMAGE, ids=lambda damaged: damaged.__name__)
def test_a_damaged_database_is_put_aside_for_its_copy(damaged, left, copy):
    left.write_bytes(damaged(left.read_bytes()))
    content = left.read_bytes()

    with pytest.raises(DatabaseUsedError, match="already contains records"):
        restore(copy, left)
    _, kept = restore(copy, left, replace=True)

    assert (names(left), kept.read_bytes()) == (["first"], content)


def test_a_service_begins_with_what_was_laid_ready_for_a_damaged_database(left, copy):
    left.write_bytes(with_a_spoiled_header(left.read_bytes()))

    lay_ready(copy, left, replace=True)
    _, kept = put_ready_in_place(left)

    assert (names(left), kept.exists()) == (["first"], True)


async def test_a_database_in_use_is_not_replaced(database, copy):
    await add(database, "first")
    back_up(database.file, copy)

    with pytest.raises(DatabaseInUseError):
        restore(copy, database.file, replace=True)
    assert names(database.file) == ["first"]


async def test_beside_a_service_a_copy_is_laid_ready_for_the_next(database_url, copy):
    database = Database(database_url)
    await add(database, "first")
    back_up(database.file, copy)
    await add(database, "second")

    with pytest.raises(DatabaseUsedError, match="already contains records"):
        lay_ready(copy, database.file)
    head, _ = lay_ready(copy, database.file, replace=True)
    with pytest.raises(DatabaseInUseError):
        put_ready_in_place(database.file)
    await add(database, "third")
    database.close()
    restored, kept = put_ready_in_place(database.file)

    assert restored == head
    assert names(database.file) == ["first"]
    assert names(kept) == ["first", "second", "third"]
    assert verify_left(database.file).findings == verify_left(kept).findings == ()
    assert put_ready_in_place(database.file) is None  # once
    assert not [*database.file.parent.glob("*to-restore*")]


def test_where_nothing_is_laid_ready_nothing_is_put_anywhere(left, tmp_path):
    assert put_ready_in_place(left) is None
    assert put_ready_in_place(tmp_path / "fresh.sqlite3") is None
    assert names(left) == ["first", "second"]
    assert not (tmp_path / "fresh.sqlite3").exists()


def test_a_start_that_was_cut_between_two_steps_is_gone_on_with(left, copy):
    _, ready = lay_ready(copy, left, replace=True)
    for part in ("", "-wal", "-shm", ".seal"):  # put aside, and then the current went
        left.with_name(f"{left.name}{part}").unlink(missing_ok=True)

    _, kept = put_ready_in_place(left)

    assert (names(left), kept, ready.exists()) == (["first"], None, False)


def test_what_was_spoiled_since_it_was_laid_ready_keeps_the_service_from_starting(left, copy):
    _, ready = lay_ready(copy, left, replace=True)
    ready.write_bytes(ready.read_bytes()[:20_000])

    with pytest.raises(BackupError):
        put_ready_in_place(left)

    assert names(left) == ["first", "second"]


def test_whole_pages_with_less_in_them_than_was_laid_ready_keep_it_from_starting_too(left, copy):
    back_up(left, copy, replace=True)
    _, ready = lay_ready(copy, left, replace=True)
    triggers = "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'"
    with LIBRARY.connect(ready) as laid:
        protection = laid.execute(triggers).fetchall()
        for name, _ in protection:
            laid.execute(f"DROP TRIGGER {name}")
        laid.execute("DELETE FROM links WHERE id = (SELECT max(id) FROM links)")
        for _, statement in protection:
            laid.execute(statement)
    laid.close()

    with pytest.raises(BackupError, match="was changed after it was prepared"):
        put_ready_in_place(left)

    assert names(left) == ["first", "second"]


async def test_a_service_begins_with_what_was_laid_ready(left, copy, database_url, caplog):
    lay_ready(copy, left, replace=True)
    (left.parent / "cell.toml").write_text(CELL)
    settings = Settings(database_url, cell_file=left.parent / "cell.toml")

    async with served(settings, Bench().registry()) as client:
        listed = (await client.get("/api/v1/sessions")).json()

    assert [one["name"] for one in listed] == ["first"]
    assert "records restored" in caplog.text and "is kept as" in caplog.text


@pytest.fixture
def drafts(left):
    """Two drafts, one with a file, beside a database."""
    folder = DraftFolder.beside(left)
    number = folder.create().id
    with folder.receiving(number) as incoming:
        incoming.write(b"q1;x\n1;2\n")
        incoming.keep("left arm/points.csv")
    folder.keep_choices(number, {"robot": "abb-irb-120"})
    folder.create()
    return folder


def test_drafts_lie_beside_a_copy_and_come_back_with_it(left, drafts, copy, tmp_path):
    made = back_up(left, copy, replace=True)
    fresh = tmp_path / "fresh" / "cell.sqlite3"
    restore(copy, fresh)

    assert (made.drafts, restore_drafts(copy, fresh)) == (2, 2)

    back = DraftFolder.beside(fresh)
    assert back.all() == drafts.all()
    assert back.path(1, 1).read_bytes() == b"q1;x\n1;2\n"


def test_a_draft_that_cannot_be_read_keeps_the_others_from_no_copy(left, drafts, copy, caplog):
    (left.with_name(f"{left.name}.drafts") / "2" / "draft.json").write_bytes(b"{")

    made = back_up(left, copy, replace=True)

    assert made.drafts == 1
    assert "Draft 2 cannot be read" in caplog.text


def full_disk(*of, **more):
    raise OSError(28, "No space left on device")


def test_of_drafts_that_the_disk_refuses_no_others_lie_beside_the_copy(left, drafts, copy, monkeypatch):
    back_up(left, copy, replace=True)
    monkeypatch.setattr(zipfile.ZipFile, "writestr", full_disk)

    with pytest.raises(BackupError, match=r"drafts of .* cannot be copied .*; the records were"):
        back_up(left, copy, replace=True)

    assert verify_left(copy).findings == ()
    assert [file.name for file in copy.parent.iterdir()] == [copy.name]


def test_a_database_that_was_transferred_is_sealed_with_its_newest_link(left, tmp_path):
    head, _ = transfer(f"sqlite:///{left}", f"sqlite:///{tmp_path}/other.sqlite3")

    assert IdentityFile(tmp_path / "other.sqlite3").left().link == head.links > 0


def test_drafts_that_a_transfer_cannot_bring_are_said_and_the_records_are_there(
    left, drafts, copy, tmp_path, monkeypatch
):
    monkeypatch.setattr(zipfile.ZipFile, "writestr", full_disk)

    with pytest.raises(BackupError, match="the records were"):
        transfer(f"sqlite:///{left}", f"sqlite:///{tmp_path}/other.sqlite3")

    assert names(tmp_path / "other.sqlite3") == names(left)


def test_drafts_that_are_there_stay(left, drafts, copy):
    back_up(left, copy, replace=True)
    drafts.remove(2)

    assert restore_drafts(copy, left) == 0
    assert drafts.numbers() == [1]


def test_without_drafts_nothing_lies_beside_a_copy_and_none_of_before(left, drafts, copy):
    back_up(left, copy, replace=True)
    drafts.remove(1)
    drafts.remove(2)

    made = back_up(left, copy, replace=True)

    assert (made.drafts, [file.name for file in copy.parent.iterdir()]) == (0, [copy.name])
    assert restore_drafts(copy, left) == 0


def test_of_an_archive_only_drafts_are_put_back(left, copy, tmp_path):
    with zipfile.ZipFile(drafts_beside(copy), "w") as archive:
        for name in ("../escape.file", "1/../../escape.file", "/1/1.file", "1/draft.json.part", "x/1.file"):
            archive.writestr(name, b"x")

    assert restore_drafts(copy, tmp_path / "fresh.sqlite3") == 0
    assert not list(tmp_path.rglob("*escape*"))


def test_a_damaged_archive_of_drafts_is_one_sentence(left, copy):
    drafts_beside(copy).write_bytes(b"PK")

    with pytest.raises(BackupError, match="the records were"):
        restore_drafts(copy, left)


def test_a_copy_that_was_changed_is_not_restored(left, copy, tmp_path):
    with LIBRARY.connect(copy) as changed:
        changed.executescript("DROP TRIGGER sessions_no_update; UPDATE sessions SET name = 'other';")
    changed.close()

    with pytest.raises(BackupError, match="Record 1 of the sessions"):
        restore(copy, tmp_path / "fresh.sqlite3")
    assert not (tmp_path / "fresh.sqlite3").exists()


async def test_the_commands_copy_restore_and_verify(database, database_url, copy, tmp_path):
    await add(database, "first")
    head = (await database.head()).text

    made = installed("backup", copy, "--database", database_url, "--json")
    refused = installed("restore", copy, "--database", database_url, "--replace")
    verified = installed("verify", copy, "--head", head)

    assert (made.returncode, json.loads(made.stdout)["head"]) == (0, head), made.stderr
    assert (refused.returncode, refused.stdout) == (3, "")
    assert "in use" in refused.stderr and "--at-next-start" in refused.stderr
    laid = installed("restore", copy, "--database", database_url, "--replace", "--at-next-start", "--json")
    assert json.loads(laid.stdout)["waits"] == f"{database.file}.to-restore", laid.stderr
    assert (verified.returncode, f"Chain head {head}" in verified.stdout) == (0, True), verified.stdout
