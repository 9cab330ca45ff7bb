"""PINs that count no more, and those of a copy, are gone; everything else is as it was written."""

from contextlib import closing

import pytest

from truepose.domain.people import Role
from truepose.storage.backup.schedule import back_up_at, restore_at
from truepose.storage.database import Database
from truepose.storage.engine.raw_connection import plain
from truepose.storage.engine.reading import open_reader
from truepose.storage.errors import ConflictError
from truepose.storage.integrity.verification import verify, verify_at
from truepose.storage.people import CredentialKind, CredentialRepository, NewCredential
from truepose.storage.secret_files import TAKEN_OUT

FIRST, SECOND = "1f0c99ab$argon2id$first", "1f0c99ab$argon2id$second"
PASSWORD = "$argon2id$of a password"


async def chosen(stored):
    """Enter Ada with a password and a PIN that took the place of another one."""
    ada, _ = await stored.enter("Ada", Role.OPERATOR, "Grace")
    kept = {CredentialKind.PASSWORD: PASSWORD, CredentialKind.PIN: FIRST}
    _, before = await stored.exchange(
        [NewCredential(kind, ada.id, it) for kind, it in kept.items()], (), "Ada"
    )
    await stored.exchange([NewCredential(CredentialKind.PIN, ada.id, SECOND)], (), "Ada")
    await stored.revoke((before.id,), "Ada")


async def left(url):
    """Leave a database in which Ada has chosen hers."""
    database = Database(url)
    await chosen(CredentialRepository(database))
    database.close()


def hashes(url):
    with closing(open_reader(url)) as connection:
        rows = connection.execute("SELECT hash FROM credentials ORDER BY id").fetchall()
    return [row[0] if isinstance(row[0], str) else bytes(row[0]).decode() for row in rows]


def changed(url, statement):
    """Change a record behind the service's back, as somebody with all rights on the database can."""
    database = Database(url)
    try:
        connection = plain(database.backend.connection)
        of = " ON credentials" if hasattr(connection, "server") else ""
        connection.execute(f"DROP TRIGGER credentials_no_update{of}")
        connection.execute(statement)
    finally:
        database.close()
    return verify_at(url).findings


async def test_a_pin_that_was_replaced_is_gone_and_the_chain_is_whole(database, database_url):
    await chosen(CredentialRepository(database))

    assert hashes(database_url) == [PASSWORD, TAKEN_OUT, SECOND]
    verdict = verify_at(database_url)
    assert (verdict.findings, verdict.records > 5) == ((), True)
    with pytest.raises(ConflictError, match="never changed"):
        await database.on_writer(lambda own: own.execute("UPDATE credentials SET hash = 'mine'"))


async def test_a_copy_holds_no_pin(database, database_url, tmp_path):
    await chosen(CredentialRepository(database))
    copy = tmp_path / "copy.sqlite3"

    back_up_at(database_url, copy)

    held = copy.read_bytes()
    assert SECOND.encode() not in held
    assert FIRST.encode() not in held
    assert PASSWORD.encode() in held  # else nobody could come in after a restore
    assert verify(copy).findings == ()
    assert hashes(database_url) == [PASSWORD, TAKEN_OUT, SECOND]


@pytest.mark.engine("sqlite")
async def test_what_is_taken_out_is_gone_from_the_file(database_url, tmp_path):
    await left(database_url)

    assert FIRST.encode() not in (tmp_path / "truepose.sqlite3").read_bytes()


@pytest.mark.engine("sqlite")
async def test_a_copy_of_an_older_version_is_put_back_without_its_pins(database_url, tmp_path):
    await left(database_url)

    restore_at(tmp_path / "truepose.sqlite3", f"sqlite:///{tmp_path}/other.sqlite3")

    assert hashes(f"sqlite:///{tmp_path}/other.sqlite3") == [PASSWORD, TAKEN_OUT, TAKEN_OUT]
    assert SECOND.encode() not in (tmp_path / "other.sqlite3").read_bytes()


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE credentials SET person_id = NULL WHERE kind = 'pin' AND hash <> 'taken out'",
        "UPDATE credentials SET hash = 'taken out' WHERE kind = 'password'",
        "UPDATE credentials SET kind = 'token' WHERE hash = 'taken out'",
    ],
)
async def test_nothing_else_of_a_credential_may_differ(database_url, statement):
    await left(database_url)

    findings = changed(database_url, statement)

    assert any("of the credentials differs from what was written" in finding for finding in findings)
