"""What follows the first release goes up and down with every record, on both engines.

The first schema alone is there so far. These tests add a second one as a later version would have it: a table
more, a column more.
"""

import shutil
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace

import pytest
import sqlalchemy as sa
from alembic import command
from alembic.script import ScriptDirectory

from tests.helpers.storage.demo_database import write_demo
from tests.studies.baseline import DIALECTS, statements
from truepose.storage import migrations
from truepose.storage.backup.transfer import transfer
from truepose.storage.database import Database
from truepose.storage.engine import schema
from truepose.storage.engine.reading import open_reader
from truepose.storage.errors import NewerSchemaError
from truepose.storage.integrity.verification import verify_at
from truepose.storage.record_insertion import add_row
from truepose.storage.tables import metadata

FOLDER = Path(migrations.__file__).parent
LATER = '''"""Audits of models."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.engine.dialects import TEXT, WHOLE
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables

revision, down_revision, branch_labels, depends_on = "0002", "0001", None, None


def upgrade():
    number = sa.Column("id", WHOLE, primary_key=True, autoincrement=True)
    recorded = sa.Column("recorded_at", TEXT, nullable=False)
    op.create_table("audits", number, recorded, sqlite_autoincrement=True)
    protect("audits")
    op.add_column("models", sa.Column("audited_by", TEXT, nullable=True))


def downgrade():
    there = chained_tables()
    drop_protected("audits")
    op.drop_column("models", "audited_by")
    chain_anew(there - {"audits"})
'''
AUDITS = sa.Table("audits", sa.MetaData(), sa.Column("id", sa.Integer), sa.Column("recorded_at", sa.Text))


@pytest.fixture
def later(tmp_path):
    """Have this program know the schema of a later version, within the context that is given back."""
    folder = tmp_path / "migrations"
    shutil.copytree(FOLDER, folder)
    (folder / "versions" / "0002_audits.py").write_text(LATER)

    @contextmanager
    def known():
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(schema, "migrations", SimpleNamespace(__file__=str(folder / "__init__.py")))
            schema.revisions.cache_clear()
            yield
        schema.revisions.cache_clear()

    return known


def everything(url):
    """Return every record of the tables that the first schema has, in the columns that it has."""
    with closing(open_reader(url)) as connection:
        found = {}
        for table in metadata.sorted_tables:
            columns = ", ".join(f'"{column.name}"' for column in table.columns)
            rows = connection.execute(f'SELECT {columns} FROM "{table.name}" ORDER BY id').fetchall()
            found[table.name] = [tuple(row) for row in rows]
        return found


@pytest.fixture
def demo_url(database_url, engine, tmp_path):
    """A database of the first schema with records of every kind."""
    file = tmp_path / ("truepose.sqlite3" if engine == "sqlite" else "demo.sqlite3")
    write_demo(file)
    if engine == "postgresql":
        transfer(f"sqlite:///{file}", database_url)
    return database_url


def migrate(database, revision):
    def work():
        config = schema.migration_config()
        with database.backend.connection.begin():
            config.attributes["connection"] = database.backend.connection
            command.downgrade(config, revision)

    database._writer.submit(work).result()


async def test_a_later_schema_changes_no_record_and_goes_again_with_its_own(demo_url, later):
    before = everything(demo_url)

    with later():
        database = Database(demo_url)
        reached, after = database.schema, everything(demo_url)
        await database.write(lambda connection: add_row(connection, AUDITS, id=1))
        migrate(database, "0001")
        database.close()

    assert (reached, after) == ("0002", before)
    left = everything(demo_url)
    assert {**left, "links": len(left["links"])} == {**before, "links": len(before["links"])}
    assert verify_at(demo_url).findings == ()
    assert len(before["readings"]) > 150


def test_a_schema_that_only_a_later_version_knows_is_refused(demo_url, later):
    with later():
        Database(demo_url).close()

    with pytest.raises(NewerSchemaError, match="has schema 0002, this version of truepose knows up to 0001"):
        Database(demo_url)


def test_there_is_no_way_below_the_first_schema(demo_url):
    database = Database(demo_url)

    with pytest.raises(NotImplementedError, match="no release"):
        migrate(database, "base")

    database.close()
    assert len(everything(demo_url)["readings"]) > 150


def test_the_names_of_the_files_tell_every_schema_in_its_order():
    steps = ScriptDirectory.from_config(schema.migration_config()).walk_revisions()  # the newest first

    assert [step.revision for step in steps] == list(reversed(schema.revisions()))


@pytest.mark.parametrize("name", [*DIALECTS])
def test_until_the_first_release_its_schema_is_that_of_the_tables(name):
    kept = (FOLDER / "versions" / f"0001_{name}.sql").read_text(encoding="utf-8")

    assert kept == statements(DIALECTS[name]), "python -m tests.studies.baseline migrations/versions"
