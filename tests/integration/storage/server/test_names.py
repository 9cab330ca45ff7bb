"""One server answers to many names, and one name leads to many databases: it says itself which it is."""

import pytest

from tests.helpers.storage.sessions import add
from truepose.storage.backup.transfer import transfer
from truepose.storage.database import Database
from truepose.storage.drafts import DraftFolder
from truepose.storage.engine.address import database_file
from truepose.storage.engine.reading import lies_beside
from truepose.storage.errors import BackupError, DatabaseInUseError, ServerRefusedError
from truepose.storage.integrity.verification import verify_left_at

pytestmark = pytest.mark.engine("postgresql")


@pytest.fixture
def renamed(server, database_url, tmp_path):
    """The address of the same database by another name of its server."""
    other = tmp_path / "other-name"
    other.symlink_to(server.folder)
    return database_url.replace(str(server.folder), str(other))


@pytest.fixture
def schema(server, database_url, name):
    """Return what makes a schema and returns the address that leads there."""

    def made(called):
        with server.connect(name) as other:
            other.execute(f'CREATE SCHEMA IF NOT EXISTS "{called}"')
        return f"{database_url}&options=-csearch_path%3D{called}"

    return made


def test_a_second_service_is_refused_by_whatever_name_it_comes(database_url, renamed):
    first = Database(database_url)
    try:
        with pytest.raises(DatabaseInUseError, match="in use by another truepose service; stop that one"):
            Database(renamed)
    finally:
        first.close()

    Database(renamed).close()


def test_by_another_name_there_are_the_same_files(database_url, renamed):
    with_one, with_other = Database(database_url), None
    DraftFolder.beside(with_one.file).create()
    with_one.close()
    with_other = Database(renamed)
    with_other.close()

    assert with_other.file == with_one.file == lies_beside(renamed)
    assert len(DraftFolder.beside(with_other.file).numbers()) == 1
    assert len([*with_one.file.parent.glob("*.seal")]) == 1


def test_a_database_is_not_copied_to_itself_under_another_name(database_url, renamed):
    with pytest.raises(BackupError, match="both source and target"):
        transfer(database_url, renamed)


async def test_two_schemas_are_two_databases_side_by_side(schema):
    urls = [schema(called) for called in ("north", "south")]
    opened = [Database(url) for url in urls]
    await add(opened[0], "northern")
    heads = [await database.head() for database in opened]
    for database in opened:
        database.close()

    assert opened[0].file != opened[1].file
    assert (heads[0].links > 0, heads[1].links) == (True, 0)
    assert [verify_left_at(url).findings for url in urls] == [(), ()]
    assert database_file(urls[0]) != database_file(urls[1])  # of which the logs are named


def test_a_name_of_a_schema_may_hold_anything_and_is_not_mistaken(schema):
    files = {lies_beside(schema(called)) for called in ("a_b", "a.b", "ä/b", "x" * 63)}

    assert len(files) == 4
    assert all(len(file.name) < 80 and file.parent.name == "postgresql" for file in files)


def test_a_schema_that_is_not_there_is_said(database_url):
    with pytest.raises(ServerRefusedError, match="none of the schemas in its search_path; create one"):
        Database(f"{database_url}&options=-csearch_path%3Dnowhere")
    with pytest.raises(ServerRefusedError, match="none of the schemas in its search_path"):
        verify_left_at(f"{database_url}&options=-csearch_path%3Dnowhere")


async def test_newest_records_that_a_database_made_anew_lacks_are_missed(server, database_url, name):
    database = Database(database_url)
    await add(database)
    database.close()
    server.drop(name)
    server.make(name)

    again = Database(database_url)
    again.close()

    assert "newest records" in again.condition.fault


def test_a_server_that_does_not_say_which_it_is_is_refused(server, database_url, name):
    with server.connect(name) as other:
        other.execute("CREATE ROLE unknowing LOGIN")
        other.execute(f'GRANT ALL ON DATABASE "{name}" TO unknowing')
        other.execute("REVOKE EXECUTE ON FUNCTION pg_control_system() FROM PUBLIC")
        try:
            with pytest.raises(ServerRefusedError, match=r"GRANT EXECUTE ON FUNCTION pg_control_system"):
                Database(database_url.replace("//postgres@", "//unknowing@"))
        finally:
            other.execute(f'REVOKE ALL ON DATABASE "{name}" FROM unknowing')
            other.execute("DROP ROLE unknowing")
