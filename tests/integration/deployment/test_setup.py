"""What `make` says on a machine that lacks something: one sentence, and nothing half made."""

import shutil
import subprocess
import sys

import pytest

from tests.helpers.checkout import CHECKOUT

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture
def set_up(tmp_path):
    """Set up an environment with a Python that does what a script says, and return what was printed."""

    def run(script):
        python = tmp_path / "python3"
        python.write_text(f"#!/bin/sh\n{script}\n")
        python.chmod(0o755)
        names = (f"PYTHON={python}", f"VENV={tmp_path / 'venv'}", "MAKEFLAGS=")
        done = subprocess.run(["make", "setup", *names], cwd=CHECKOUT, capture_output=True, text=True)
        assert done.returncode == 2
        assert not (tmp_path / "venv").exists()
        said = [line for line in done.stderr.splitlines() if not line.startswith("make")]
        assert len(said) == 1
        return said[0]

    return run


# What stands for a Python that is otherwise ours but cannot do what a line of the arguments names.
_WITHOUT = """case "$2" in *{lacking}*) echo "a long text" >&2; exit 1;; esac\nexec {python} "$@" """


@pytest.mark.parametrize(
    "script", ["exit 1", "exit 127", _WITHOUT.format(lacking="11", python=sys.executable)]
)
def test_an_interpreter_that_is_too_old_is_named_in_a_sentence(set_up, script):
    said = set_up(script)

    assert said.startswith("truepose needs Python 3.11 or newer")
    assert "PYTHON=python3.13" in said


def test_where_environments_cannot_be_made_a_sentence_says_what_to_install(set_up):
    said = set_up(_WITHOUT.format(lacking="ensurepip", python=sys.executable))

    assert "apt-get install python3-venv" in said
