"""A real database in a folder of the test's own."""

import shutil

import pytest

from tests.helpers.machine import POSTGRESQL
from tests.helpers.postgresql.server import programs, shared_server
from truepose.storage.database import Database
from truepose.storage.engine.address import database_file


@pytest.fixture(scope="session")
def server():
    """A real PostgreSQL server, which a whole run shares."""
    if programs() is None:
        pytest.skip(POSTGRESQL.reason)
    with shared_server() as running:
        yield running


@pytest.fixture
def database_url(tmp_path):
    return f"sqlite:///{tmp_path}/truepose.sqlite3"


@pytest.fixture
def database(database_url, empty_database):
    """A copy of the empty database, open."""
    if database_url.startswith("sqlite:"):
        shutil.copy(empty_database, database_file(database_url))
    opened = Database(database_url)
    yield opened
    opened.close()
