"""Where a service stores when nobody says."""

from pathlib import Path

import pytest

from truepose.settings import Settings
from truepose.storage.engine.files import data_folder


@pytest.mark.parametrize(
    ("platform", "variable"),
    [("linux", "XDG_DATA_HOME"), ("win32", "LOCALAPPDATA")],
)
def test_the_platform_says_where_the_users_data_is(monkeypatch, platform, variable):
    monkeypatch.setattr("sys.platform", platform)
    monkeypatch.setenv(variable, "somewhere")

    assert data_folder() == Path("somewhere") / "truepose"


def test_the_database_does_not_depend_on_the_working_directory(monkeypatch, tmp_path):
    before = Settings().database_url
    monkeypatch.chdir(tmp_path)

    assert Settings().database_url == before
    assert str(data_folder()) in before
