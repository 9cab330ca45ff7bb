"""A shop's database goes from a file to a server and back, bit for bit, or not at all."""

import asyncio
import contextlib
import json
import math
import shutil
from contextlib import closing

import pytest

from tests.helpers.commands import installed
from tests.helpers.domain.tracker_sessions import make_plan, make_point, make_setup, point_taken
from tests.helpers.postgresql.line import Line
from truepose.storage.backup import transfer as transferring
from truepose.storage.backup.schedule import back_up_at, restore_at
from truepose.storage.backup.transfer import transfer
from truepose.storage.database import Database
from truepose.storage.drafts import DraftFolder
from truepose.storage.engine.reading import lies_beside, open_reader
from truepose.storage.errors import BackupError, DatabaseInUseError, DatabaseUsedError, ServerAwayError
from truepose.storage.integrity.database_identity import IdentityFile
from truepose.storage.integrity.verification import verify_left, verify_left_at
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.record_insertion import add_row
from truepose.storage.records import RequestKey
from truepose.storage.tables import campaigns, metadata, readings

pytestmark = pytest.mark.engine("postgresql")
ODD = "Zoë 😀 \\N \\x41 \t\n\"quoted\" 'and' %s ?"
TIMES_S = (0.0, -0.0, 0.1, 1e-320, 1.7976931348623157e308, 1 / 3, math.inf, -math.inf, 2.0**53 + 2)


async def fill(database):
    """Write what engines might keep in ways of their own."""
    sessions, ledger = SessionRepository(database), LedgerRepository(database)
    number = await sessions.add(ODD, make_setup(), make_plan(), RequestKey("tap", "fingerprint"))
    await sessions.add("second", make_setup(), make_plan())
    for config in range(1, 4):
        await ledger.append(number, point_taken(make_point(config)))

    def odd(connection):
        for time_s in TIMES_S:
            values = {
                "kind": "point",
                "nest": 2**40,
                "document": {"x": time_s if math.isfinite(time_s) else None},
            }
            add_row(connection, readings, session_id=number, time_s=time_s, **values)
        texts = {"name": "", "robot": ODD, "summary": {"ä": "\u2028\0", "n": 1.0}, "session_ids": [number]}
        add_row(connection, campaigns, archive=bytes(range(256)), campaign=b"", **texts)

    await database.write(odd)


@pytest.fixture
async def file(tmp_path):
    """A file with records, which nobody has open."""
    url = f"sqlite:///{tmp_path}/shop.sqlite3"
    database = Database(url)
    await fill(database)
    database.close()
    return url


def everything(url):
    """Return every value of every table as it is kept, with its kind."""
    with closing(open_reader(url)) as connection:
        found = {}
        for table in metadata.tables:
            columns = ", ".join(f'"{column.name}"' for column in metadata.tables[table].columns)
            rows = connection.execute(f'SELECT {columns} FROM "{table}"').fetchall()
            found[table] = sorted(repr([_plain(value) for value in row]) for row in rows)
        return found


def _plain(value):
    return value.decode() if isinstance(value, bytearray) else value


WHOEVER_HAS_THE_LOCK = "pid IN (SELECT pid FROM pg_locks WHERE locktype = 'advisory')"
ALL = "application_name = 'truepose'"


@pytest.fixture
def end(server, name):
    """Return what ends some of the connections to the server's database, and returns how many."""

    def ended(which):
        found = f"SELECT pid FROM pg_stat_activity WHERE datname = %s AND {which}"
        with server.connect() as administrator:
            return administrator.execute(
                f"SELECT pg_terminate_backend(pid, 5000) FROM ({found}) AS found", (name,)
            ).rowcount

    return ended


@contextlib.contextmanager
def behind(step, act):
    """Have something happen behind a step of every transfer meanwhile."""
    real = getattr(transferring, step)

    def both(*arguments):
        real(*arguments)
        act()

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(transferring, step, both)
        yield


STEPS = pytest.mark.parametrize("step", ["_copy_tables", "_require_same"])


async def test_a_copied_database_is_the_same_bit_for_bit_on_both_engines(file, database_url, tmp_path):
    back = f"sqlite:///{tmp_path}/back.sqlite3"

    head, _ = transfer(file, database_url)
    transfer(database_url, back)

    assert everything(file) == everything(database_url) == everything(back)
    for url in (file, database_url, back):
        verdict = verify_left_at(url)
        assert (verdict.findings, verdict.head) == ((), head)
        assert IdentityFile(lies_beside(url)).left().link == head.links > 0


async def test_the_same_records_have_the_same_hashes_whichever_engine_they_were_written_on(
    database_url, tmp_path, monkeypatch
):
    written = []
    for url in (database_url, f"sqlite:///{tmp_path}/file.sqlite3"):
        database = Database(url)
        monkeypatch.setattr("truepose.storage.record_insertion.datetime", _Stopped)
        await fill(database)
        written.append(await database.head())
        database.close()

    assert written[0] == written[1]
    assert written[0].links > 20


class _Stopped:
    @staticmethod
    def now(zone):
        from datetime import datetime

        return datetime(2026, 3, 3, 10, tzinfo=zone)


async def test_a_service_goes_on_where_the_other_engine_ended(file, database_url):
    transfer(file, database_url)

    database = Database(database_url)
    sessions = SessionRepository(database)
    assert await sessions.add("third", make_setup(), make_plan(), RequestKey("tap 2", "x")) == 3
    assert await sessions.answered(RequestKey("tap", "fingerprint")) == 1
    database.close()

    assert verify_left_at(database_url).findings == ()


async def test_a_target_with_records_is_refused_and_stays_as_it_is(file, database_url):
    database = Database(database_url)
    await SessionRepository(database).add("theirs", make_setup(), make_plan())
    database.close()

    with pytest.raises(DatabaseUsedError, match="already contains records; choose an empty database"):
        transfer(file, database_url)

    assert len(everything(database_url)["sessions"]) == 1


@pytest.mark.parametrize("there", ["source", "target"])
async def test_neither_may_be_in_use(file, database_url, there):
    holder = Database({"source": file, "target": database_url}[there])
    try:
        with pytest.raises(DatabaseInUseError):
            transfer(file, database_url)
    finally:
        holder.close()


async def test_while_it_is_copied_no_service_gets_the_source(file, database_url, tmp_path):
    transfer(file, database_url)
    refused = []

    def ask():
        with pytest.raises(DatabaseInUseError):
            Database(database_url)
        refused.append(True)

    with behind("_copy_tables", ask):
        transfer(database_url, f"sqlite:///{tmp_path}/back.sqlite3")

    assert refused == [True]


@STEPS
async def test_a_copy_ends_with_the_lock_that_kept_services_off_its_source(
    file, database_url, end, tmp_path, step
):
    transfer(file, database_url)
    target = f"sqlite:///{tmp_path}/back.sqlite3"

    def lose():
        assert end(WHOEVER_HAS_THE_LOCK) == 1
        Database(database_url).close()  # a service gets it now

    with (
        behind(step, lose),
        pytest.raises(BackupError, match=r"cannot be copied to .*nothing was kept\.") as refused,
    ):
        transfer(database_url, target)

    assert "\n" not in str(refused.value)
    assert not any(everything(target).values())
    transfer(database_url, target)
    assert everything(target) == everything(database_url)


@STEPS
async def test_a_copy_ends_with_the_lock_that_kept_services_off_its_target(file, database_url, end, step):
    ended = []

    with (
        behind(step, lambda: ended.append(end(WHOEVER_HAS_THE_LOCK))),
        pytest.raises(BackupError, match=r"cannot be copied to .*nothing was kept\.") as refused,
    ):
        transfer(file, database_url)

    assert ended == [1]
    assert "\n" not in str(refused.value)
    assert not any(everything(database_url).values())


@pytest.mark.parametrize("when", ["before", "after"])
async def test_a_commit_whose_answer_is_lost_is_not_said_to_have_kept_nothing(
    file, database_url, server, tmp_path_factory, when
):
    line = Line(server, tmp_path_factory.mktemp("line"))

    with (
        behind("_require_same", lambda: line.cut_next_commit(when)),
        pytest.raises(BackupError, match=r"it now holds every record, or none; check with 'truepose verify'"),
    ):
        transfer(file, database_url.replace(str(server.folder), str(line.folder)))
    line.close()

    assert (everything(file) == everything(database_url)) is (when == "after")
    assert any(everything(database_url).values()) is (when == "after")


@STEPS
async def test_a_backup_whose_connection_ends_leaves_no_file(file, database_url, end, tmp_path, step):
    transfer(file, database_url)
    copy = tmp_path / "copies" / "copy.sqlite3"

    with behind(step, lambda: end(ALL)), pytest.raises(BackupError, match=r"nothing was kept\."):
        back_up_at(database_url, copy)

    assert [*copy.parent.iterdir()] == []


async def test_a_verification_whose_connection_ends_says_so_and_finds_nothing(file, database_url, end):
    transfer(file, database_url)
    asked = []

    def told(share):
        if not asked:
            asked.append(end(ALL))

    with pytest.raises(ServerAwayError, match="does not respond"):
        verify_left_at(database_url, told)
    assert asked == [1]


@STEPS
async def test_what_is_cut_short_leaves_nothing_and_can_be_begun_anew(file, database_url, step):
    def cut():
        raise KeyboardInterrupt

    with behind(step, cut), pytest.raises(KeyboardInterrupt):
        transfer(file, database_url)
    assert not any(everything(database_url).values())

    transfer(file, database_url)
    assert everything(file) == everything(database_url)


async def test_a_source_that_is_not_whole_is_not_copied(file, database_url, tmp_path):
    from truepose.storage.engine.sqlite_connections import LIBRARY

    with LIBRARY.connect(tmp_path / "shop.sqlite3") as changed:
        changed.executescript("DROP TRIGGER sessions_no_update; UPDATE sessions SET name = 'x' WHERE id = 2;")
    changed.close()

    with pytest.raises(BackupError, match=r"Record 2 of the sessions.*Nothing was kept"):
        transfer(file, database_url)
    assert not any(everything(database_url).values())


async def test_a_text_that_a_server_does_not_take_is_said_and_nothing_is_kept(database_url, tmp_path):
    url = f"sqlite:///{tmp_path}/nul.sqlite3"
    database = Database(url)
    await SessionRepository(database).add("nothing\0in it", make_setup(), make_plan())
    database.close()

    with pytest.raises(BackupError, match="NUL"):
        transfer(url, database_url)
    assert not any(everything(database_url).values())


async def test_drafts_go_with_it(file, database_url, tmp_path):
    DraftFolder.beside(tmp_path / "shop.sqlite3").create()

    assert transfer(file, database_url)[1] == 1


async def test_a_copy_of_a_server_in_use_holds_all_that_was_acknowledged(database, database_url, tmp_path):
    await fill(database)
    copy = tmp_path / "copies" / "copy.sqlite3"

    made = await asyncio.to_thread(back_up_at, database_url, copy)

    assert made.head == await database.head()
    assert [path.name for path in copy.parent.iterdir()] == ["copy.sqlite3"]
    assert verify_left(copy).findings == ()
    assert everything(f"sqlite:///{copy}") == everything(database_url)


async def test_a_copy_is_restored_into_an_empty_database_of_a_server(file, database_url, tmp_path):
    copy = tmp_path / "copy.sqlite3"
    made = back_up_at(file, copy)

    head, kept = restore_at(copy, database_url)

    assert (head, kept) == (made.head, None)
    assert everything(file) == everything(database_url)
    with pytest.raises(DatabaseUsedError):
        restore_at(copy, database_url)
    with pytest.raises(BackupError, match="A database on a server is not moved aside"):
        restore_at(copy, database_url, replace=True)


async def test_a_spoilt_copy_is_not_restored(file, database_url, tmp_path):
    copy = tmp_path / "copy.sqlite3"
    back_up_at(file, copy)
    content = bytearray(copy.read_bytes())
    content[len(content) // 2 :] = bytes(len(content) - len(content) // 2)
    copy.write_bytes(content)

    with pytest.raises(BackupError, match="failed verification"):
        restore_at(copy, database_url)
    assert not any(everything(database_url).values())


async def test_the_command_copies_and_says_what(file, database_url, tmp_path):
    done = installed("copy", tmp_path / "shop.sqlite3", database_url, "--json")
    verified = installed("verify", database_url, "--json")
    again = installed("copy", file, database_url)

    told, found = json.loads(done.stdout), json.loads(verified.stdout)
    assert (done.returncode, told["head"], told["records"]) == (0, found["head"], found["records"])
    assert found["whole"] and found["records"] > 20
    assert (again.returncode, "already contains records" in again.stderr) == (2, True), again.stderr
    shutil.rmtree(tmp_path / "beside")
