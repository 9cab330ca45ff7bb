"""Tests of the storage run on a file of SQLite and on a real PostgreSQL server, unless they are about one."""

import itertools
import os

import pytest

from truepose.storage.integrity import monitor

ENGINES = ("sqlite", "postgresql")
_NUMBERS = itertools.count()


def pytest_generate_tests(metafunc):
    if "database_url" in metafunc.fixturenames:
        only = metafunc.definition.get_closest_marker("engine")
        metafunc.parametrize("engine", ENGINES if only is None else only.args, scope="function")


@pytest.fixture(autouse=True)
def looks_often(monkeypatch):
    """A guard looks at its database twenty times a second instead of once."""
    monkeypatch.setattr(monitor, "_LOOK_S", 0.05)


@pytest.fixture
def beside(tmp_path, monkeypatch):
    """What lies on this machine of a server's database."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "beside"))


@pytest.fixture
def name(database_url):
    """The name of a database on its server."""
    return database_url.split("/")[3].split("?")[0]


@pytest.fixture
def database_url(engine, request, tmp_path):
    if engine == "sqlite":
        yield f"sqlite:///{tmp_path}/truepose.sqlite3"
        return
    request.getfixturevalue("beside")
    server, name = request.getfixturevalue("server"), f"test_{os.getpid()}_{next(_NUMBERS)}"
    yield server.make(name)
    server.drop(name)
