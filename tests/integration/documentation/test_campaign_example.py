"""The campaign folder that the README shows, through the commands that the README shows."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

_FOLDER = Path(__file__).parents[3] / "docs" / "examples" / "campaign"


def _truepose(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "service", *map(str, arguments)],
        cwd=cwd,
        env={"PYTHONPATH": str(_FOLDER.parents[2]), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """The answer of `identify --json` and the model file that it wrote."""
    folder = tmp_path_factory.mktemp("identified")
    done = _truepose("identify", _FOLDER, "--model-out", "robot.json", "--json", cwd=folder)
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

    passed = _truepose(*validate, 0.1, cwd=tmp_path)
    failed = _truepose(*validate, 0.001, cwd=tmp_path)

    assert (passed.returncode, failed.returncode) == (0, 1)
    assert (json.loads(passed.stdout)["pass"], json.loads(failed.stdout)["pass"]) == (True, False)


def test_the_example_model_predicts_the_rows_it_is_given(identified, tmp_path):
    _, model = identified

    done = _truepose("predict", model, _FOLDER / "validation.csv", "--out", "predicted.csv", cwd=tmp_path)

    assert done.returncode == 0, done.stderr
    with (
        (tmp_path / "predicted.csv").open(newline="") as predicted,
        (_FOLDER / "validation.csv").open() as given,
    ):
        rows = list(csv.DictReader(predicted))
        assert [row["config"] for row in rows] == [row["config"] for row in csv.DictReader(given)]
    assert list(rows[0]) == ["config", "nest", "x_mm", "y_mm", "z_mm", "u_mm"]
