"""A real database in a folder of the test's own."""

import pytest

from truepose.storage.database import Database


@pytest.fixture
def database_url(tmp_path):
    return f"sqlite:///{tmp_path}/truepose.sqlite3"


@pytest.fixture
def database(database_url):
    opened = Database(database_url)
    yield opened
    opened.close()
