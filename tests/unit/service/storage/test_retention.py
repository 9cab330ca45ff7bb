"""What may go beside a database, and that no record is among it."""

import os

import pytest

from truepose.storage.backup.schedule import Rules, drop, surplus

DAY_S = 86400.0
NOW_S = 1_800_000_000.0
STAYS = (
    "cell.db",
    "cell.db-wal",
    "cell.db.seal",
    "cell.db.lock",
    "cell.db.log",
    "cell.db.reserve",
    "cell.db.cell.json",
    "cell.db.before-restore-20260101T000000Z",
    "other.db.log.1",
    "somebody.part",
)


@pytest.fixture
def database(tmp_path):
    for name in STAYS:
        make(tmp_path / name, 1000)
    return tmp_path / "cell.db"


def make(file, days):
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(b"x" * 10)
    os.utime(file, (NOW_S - days * DAY_S,) * 2)
    return file


def told(database, **rules):
    return surplus(database, Rules(**rules), lambda: NOW_S)


def test_nothing_that_was_recorded_may_go(database, tmp_path):
    assert told(database, copies=tmp_path / "copies") == []


def test_old_logs_may_go_and_young_ones_stay(database, tmp_path):
    old, _ = make(tmp_path / "cell.db.log.2", 91), make(tmp_path / "cell.db.log.1", 89)

    (found,) = told(database)
    assert (found.file, found.size_bytes, found.why) == (old, 10, "log, 91 days old")


LEFT = [
    "cell.db.rescued",
    "cell.db.restored",
    "cell.db.to-restore.part",
    "copies/truepose-20260101T000000Z.sqlite3.part",
    "copies/truepose-20260101T000000Z.sqlite3.part-wal",
    "copies/truepose-20260101T000000Z.sqlite3.part.lock",
    "copies/truepose-20260101T000000Z.sqlite3.drafts.zip.part",
]


@pytest.mark.parametrize(("days", "goes"), [(2, True), (0.5, False)])
@pytest.mark.parametrize("name", LEFT)
def test_what_an_interrupted_copy_left_may_go_when_no_copy_is_under_way(database, tmp_path, name, days, goes):
    make(tmp_path / "copies" / "by-hand.sqlite3.part", 500)
    left = make(tmp_path / name, days)

    assert [one.file for one in told(database, copies=tmp_path / "copies")] == [left] * goes


def test_surplus_copies_may_go_the_oldest_first_and_files_by_hand_stay(database, tmp_path):
    for day in (1, 2, 3):
        make(tmp_path / "copies" / f"truepose-2026010{day}T000000Z.sqlite3", 3)
        make(tmp_path / "copies" / f"truepose-2026010{day}T000000Z.sqlite3.drafts.zip", 3)
    make(tmp_path / "copies" / "by-hand.sqlite3", 500)

    found = told(database, copies=tmp_path / "copies", keep_copies=2)

    assert [one.file.name for one in found] == [
        "truepose-20260101T000000Z.sqlite3",
        "truepose-20260101T000000Z.sqlite3.drafts.zip",
    ]


def test_what_may_go_goes_when_it_is_dropped_and_not_before(database, tmp_path):
    make(tmp_path / "cell.db.log.2", 91)
    found = told(database)
    assert found[0].file.exists()

    drop(found)

    assert told(database) == []
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(STAYS)
