"""The `truepose` command as a user types it: a process of its own, or this one, which has loaded everything.

A command that is tested by several lines is a process in one of them at least: there it must find by itself
whatever it imports.
"""

import contextlib
import io
import subprocess
import sys
from pathlib import Path

from truepose.cli import main

TRUEPOSE = Path(sys.executable).with_name("truepose")


def installed(*arguments):
    """Run the installed command, a process of its own."""
    command = [str(TRUEPOSE), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=180, check=False)


def typed(*arguments, cwd="."):
    """Run the command in this process, which spares it the second in which a new one loads everything."""
    printed, said = io.StringIO(), io.StringIO()
    given, sys.argv = sys.argv, ["truepose", *map(str, arguments)]
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said), contextlib.chdir(cwd):
            status = main()
    finally:
        sys.argv = given
    return subprocess.CompletedProcess(sys.argv, status, printed.getvalue(), said.getvalue())


def answer(*arguments):
    """What a command that is `typed` ends with, prints and says."""
    done = typed(*arguments)
    return done.returncode, done.stdout, done.stderr


def assert_one_sentence(done, *words, status=2):
    """The command ended with this status and said, in one line, why."""
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert done.stdout == ""
