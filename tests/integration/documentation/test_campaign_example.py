"""The campaign folder of the examples, and the commands that the README shows."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.checkout import SOURCES
from tests.helpers.commands import typed
from tests.helpers.exchange.rows import read_rows

_CHECKOUT = Path(__file__).parents[3]
_FOLDER = _CHECKOUT / "docs" / "examples" / "campaign"
_PASSED = "Mean error 0.527 mm before (nominal), 0.0273 mm after; largest 0.0627 mm, limit 0.2 mm: pass."


def _truepose(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "truepose", *map(str, arguments)],
        cwd=cwd,
        env={"PYTHONPATH": os.pathsep.join(SOURCES), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
        timeout=180,
    )


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """The answer of `identify --json` and the model file that it wrote."""
    folder = tmp_path_factory.mktemp("identified")
    done = typed("identify", _FOLDER, "--model-out", "robot.json", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), folder / "robot.json"


def test_the_example_is_identified_to_what_its_noise_allows(identified):
    answer, _ = identified

    assert answer["status"] == "converged"
    assert answer["counts"]["parameters"] == 31
    held_out = answer["statistics"]["validation"]
    # 31 parameters from 90 coordinates of 0.015 mm: the model adds about 0.6 of the noise, 20 points
    # scatter by a tenth; 1.5 times the noise is four of these away.
    assert held_out["identified"]["mean_mm"] < 1.5 * held_out["identified"]["noise_mm"]
    assert held_out["nominal"]["mean_mm"] > 10.0 * held_out["identified"]["mean_mm"]


def test_the_example_model_passes_validation_and_fails_an_impossible_limit(identified, tmp_path):
    _, model = identified
    validate = ("validate", model, _FOLDER / "validation.csv", "--json", "--limit-mm")

    passed = typed(*validate, 0.1, cwd=tmp_path)
    failed = typed(*validate, 0.001, cwd=tmp_path)

    assert (passed.returncode, failed.returncode) == (0, 1)
    assert (json.loads(passed.stdout)["pass"], json.loads(failed.stdout)["pass"]) == (True, False)


def test_the_example_model_predicts_the_rows_it_is_given(identified, tmp_path):
    _, model = identified

    done = typed("predict", model, _FOLDER / "validation.csv", "--out", "predicted.csv", cwd=tmp_path)

    assert done.returncode == 0, done.stderr
    rows = read_rows(tmp_path / "predicted.csv")
    assert [row["config"] for row in rows] == [row["config"] for row in read_rows(_FOLDER / "validation.csv")]
    assert list(rows[0]) == ["config", "nest", "x_mm", "y_mm", "z_mm", "u_mm"]


def test_the_commands_of_the_readme_work_one_after_the_other(tmp_path):
    readme = (_CHECKOUT / "README.md").read_text(encoding="utf-8")
    lines = re.findall(r"^truepose ((?:import|diagnose|validate) .*)$", readme, flags=re.MULTILINE)
    shutil.copytree(_CHECKOUT / "docs" / "examples" / "wave", tmp_path / "docs" / "examples" / "wave")

    first, *others = (shlex.split(line) for line in lines)
    done = [_truepose(*first, cwd=tmp_path), *(typed(*line, cwd=tmp_path) for line in others)]

    assert [line.split()[0] for line in lines] == ["import", "diagnose", "validate"]
    assert [run.returncode for run in done] == [0] * 3, "".join(run.stderr for run in done)
    assert "\n".join(done[1].stdout.splitlines()[:2]) in readme
    assert " ".join(done[2].stdout.split())[: len(_PASSED)] == _PASSED
    assert _PASSED in readme
    assert (tmp_path / "diagnosis.html").is_file()
