"""The tables that the program knows are those that the migrations make."""

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from truepose.storage.connection.address import parsed_url
from truepose.storage.connection.postgresql.connections import writing_engine
from truepose.storage.integrity.chain import ROWID
from truepose.storage.tables import metadata


@pytest.fixture
def migrated(database):
    """What reads the database that migrations have made."""
    with database.held.readers.connect() as connection:
        yield connection


@pytest.fixture
def made(database_url, engine):
    """What reads tables that were made without migrations, of a server in a schema of their own."""
    elsewhere = sa.create_engine("sqlite://")
    if engine == "postgresql":
        elsewhere = writing_engine(parsed_url(f"{database_url}&options=-csearch_path%3Dmade"))
    with elsewhere.connect() as connection:
        if engine == "postgresql":
            connection.execute(sa.text("CREATE SCHEMA made"))
        metadata.create_all(connection)
        yield connection
    elsewhere.dispose()


def columns(connection):
    """Return the columns of every table as the engine has them."""
    found = sa.inspect(connection)
    return {
        (table, column["name"]): (str(column["type"]), column["nullable"], _collation(column))
        for table in metadata.tables
        for column in found.get_columns(table)
        if column["name"] != ROWID
    }


def _collation(column):
    return getattr(column["type"], "collation", None)


def _ours(_object, name, *_of):
    """Whether something is of a table, and not what a server needs to number rows without an `id`."""
    return name not in {ROWID, f"request_keys_{ROWID}_key"}


def test_nothing_that_migrations_compare_differs(migrated):
    compared = MigrationContext.configure(migrated, opts={"compare_type": True, "include_object": _ours})

    assert compare_metadata(compared, metadata) == []


def test_columns_are_the_same_with_migrations_and_without(migrated, made):
    found = columns(migrated)

    assert len(found) > 150
    assert found == columns(made)
