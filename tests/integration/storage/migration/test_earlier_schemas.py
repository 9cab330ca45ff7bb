"""Databases of every schema that was in use: taken over whole; and none is forgotten."""

import json
import lzma
from pathlib import Path

import pytest

from tests.studies.left_database import dumped
from truepose.demo.night.earlier import earlier_schemas, write_earlier
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.database import Database
from truepose.storage.integrity.verification import verify

VERSIONS = Path(__file__).parents[4] / "migrations" / "versions"
# Landed together with a later one: no program ever left such a database.
NEVER_LEFT = {"0001", "0002", "0004"}


def readings(file):
    connection = LIBRARY.connect(file)
    try:
        return connection.execute("SELECT id, document FROM readings ORDER BY id").fetchall()
    finally:
        connection.close()


@pytest.mark.parametrize("schema", earlier_schemas())
def test_it_is_taken_over_whole(schema, tmp_path):
    file = tmp_path / "truepose.sqlite3"
    write_earlier(schema, file)
    before = readings(file)

    Database(f"sqlite:///{file}").close()

    assert len(before) > 150
    assert readings(file) == before
    assert verify(file).findings == ()


def test_a_reading_that_the_earlier_program_wrote_is_not_changed_unseen(tmp_path):
    file = tmp_path / "truepose.sqlite3"
    write_earlier("0010", file)
    Database(f"sqlite:///{file}").close()
    with LIBRARY.connect(file) as connection:
        ((document,),) = connection.execute("SELECT document FROM readings WHERE id = 7").fetchall()
        changed = json.loads(document) | {"position_tracker_mm": [0.0, 0.0, 0.0]}
        connection.execute("DROP TRIGGER readings_no_update")
        connection.execute("UPDATE readings SET document = ? WHERE id = 7", (json.dumps(changed),))

    assert any("7" in finding for finding in verify(file).findings)


def test_every_schema_but_the_present_one_is_kept():
    revisions = sorted(file.name[:4] for file in VERSIONS.glob("[0-9]*.py"))

    assert set(earlier_schemas()) == set(revisions[:-1]) - NEVER_LEFT


def test_a_database_that_is_left_can_be_written_again(tmp_path):
    write_earlier("0003", tmp_path / "old.sqlite3")

    schema, dump = dumped(tmp_path / "old.sqlite3")

    assert schema == "0003"
    assert "CREATE TABLE readings" in lzma.decompress(lzma.compress(dump.encode())).decode()
