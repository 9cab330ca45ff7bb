"""The demo where calls are missing that Windows lacks; that Windows has the others is not tried by it."""

import os
import subprocess
import sys

import pytest

from tests.helpers.checkout import CHECKOUT
from tests.thorough.system.demo.test_demo import DEMO_S, of_size

_LACKING = CHECKOUT / "tests" / "thorough" / "system" / "demo" / "without_posix"


@pytest.fixture(scope="module")
def without_posix():
    """The environment of a process, and of all that it starts, without what Windows lacks."""
    rooms = [_LACKING, *(CHECKOUT / room for room in ("service", "drivers", "simulators"))]
    return os.environ | {"PYTHONPATH": os.pathsep.join(map(str, rooms))}


def test_calls_are_missing_that_windows_lacks(without_posix):
    asked = "import os, signal; assert not {'killpg', 'SIGKILL'} & {*dir(os), *dir(signal)}; import termios"

    done = subprocess.run(
        [sys.executable, "-c", asked], env=without_posix, capture_output=True, text=True, check=False
    )

    assert "ModuleNotFoundError: import of termios halted" in done.stderr


def test_the_demo_ends_well_where_calls_of_posix_are_missing(without_posix, tmp_path):
    done = subprocess.run(
        [sys.executable, *of_size(25, 5), str(tmp_path)],
        env=without_posix,
        capture_output=True,
        text=True,
        timeout=DEMO_S,
        check=False,
    )

    assert (done.returncode, "Traceback" in done.stderr) == (0, False), done.stderr
    assert (tmp_path / "result.json").is_file()
    assert "stopped cleanly" in (tmp_path / "service.log").read_text(encoding="utf-8")
