"""The tutorial, as somebody types it: from its cell file to a correction that is proved."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.helpers.checkout import CHECKOUT, SOURCES

_PAGE = (CHECKOUT / "docs" / "tutorial.md").read_text(encoding="utf-8")
_WAITS_S = 400


def _blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", _PAGE, flags=re.DOTALL | re.MULTILINE)


def _environment():
    shell = {name: os.environ[name] for name in ("PATH", "HOME") if name in os.environ}
    return shell | {"PYTHONPATH": os.pathsep.join(SOURCES), "OPENBLAS_NUM_THREADS": "1"}


@pytest.fixture
def folder(tmp_path):
    (cell,), (program,) = _blocks("toml"), _blocks("rapid")
    (tmp_path / "cell.toml").write_text(cell, encoding="utf-8")
    (tmp_path / "square.mod").write_text(program, encoding="utf-8")
    return tmp_path


@pytest.fixture
def address(folder):
    (line,) = re.findall(r"^truepose (serve .*)$", _PAGE, flags=re.MULTILINE)
    command = [sys.executable, "-m", "truepose", *line.split(), "--port", "0"]
    with subprocess.Popen(command, cwd=folder, env=_environment(), stdout=subprocess.PIPE) as service:
        yield json.loads(service.stdout.readline())["url"].removeprefix("http://")
        service.terminate()


@pytest.mark.skipif(shutil.which("curl") is None, reason="curl is not installed")
def test_the_tutorial_ends_with_a_corrected_and_proved_program(folder, address):
    typed = "\n".join(_blocks("sh")).replace("localhost:8000", address)
    typed = typed.replace("truepose correct", f"{sys.executable} -m truepose correct")

    done = subprocess.run(
        ["bash", "-eu", "-c", typed], cwd=folder, env=_environment(), capture_output=True, text=True,
        check=False, timeout=_WAITS_S,
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    assert "The model does not include joint harmonics (joint 5)" in done.stdout
    assert "3 of 3 targets corrected." in done.stdout
    assert done.stdout.endswith('"proved":true\n')
    before, after = ((folder / f"square{kind}.mod").read_text().splitlines() for kind in ("", "-corrected"))
    assert [n for n, (old, new) in enumerate(zip(before, after, strict=True)) if old != new] == [1, 2, 3]
