"""Commands whose work is many parts, typed in this process."""

import pytest

from truepose.cli import main


@pytest.fixture
def truepose(monkeypatch, capsys):
    """The command in this process; its workers are processes of their own."""

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["truepose", *map(str, arguments)])
        status = main()
        said = capsys.readouterr()
        return status, said.out, said.err

    return run
