"""The tables that the program knows are those that the migrations make."""

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext

from truepose.storage.engine.address import parsed_url
from truepose.storage.engine.postgresql_connections import writing_engine
from truepose.storage.tables import metadata


@pytest.fixture
def migrated(database):
    """What reads the database that migrations have made."""
    with database.backend.readers.connect() as connection:
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
    }


def _collation(column):
    return getattr(column["type"], "collation", None)


def test_nothing_that_migrations_compare_differs(migrated):
    compared = MigrationContext.configure(migrated, opts={"compare_type": True})

    assert compare_metadata(compared, metadata) == []


def test_columns_are_the_same_with_migrations_and_without(migrated, made):
    found = columns(migrated)

    assert len(found) > 150
    assert found == columns(made)
