"""What `truepose` says by itself, by what lies in the folder."""

import json
import os
import subprocess
import sys
import zipfile

import pytest

from truepose.cli.next_command import introduction

MODEL = json.dumps({"format": "truepose-model", "version": 1})


def commands(folder):
    return [line.strip() for line in introduction(folder).splitlines() if line.startswith("  truepose")]


def laid(folder, **files):
    for name, text in files.items():
        file = folder / name.replace("__", "/").replace("_", ".")
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    return folder


def test_in_an_empty_folder_everything_begins(tmp_path):
    assert [line.split()[1] for line in commands(tmp_path)] == ["demo", "serve", "import"]


def test_readings_become_a_campaign(tmp_path):
    assert commands(laid(tmp_path, readings_csv="x")) == ["truepose import readings.csv --out campaign"]


def test_a_campaign_is_identified_and_diagnosed(tmp_path):
    laid(tmp_path, arm__campaign_json="{}", arm__calibration_csv="")

    assert commands(tmp_path) == [
        "truepose identify arm --model-out model.json",
        "truepose diagnose arm --report diagnosis.html",
    ]
    assert commands(tmp_path / "arm")[0] == "truepose identify . --model-out model.json"


def test_so_is_a_zip_of_one(tmp_path):
    with zipfile.ZipFile(tmp_path / "left arm.zip", "w") as archive:
        archive.writestr("arm/campaign.json", "{}")

    assert commands(tmp_path)[0] == "truepose identify 'left arm.zip' --model-out model.json"


def test_a_model_is_validated_before_it_corrects(tmp_path):
    laid(tmp_path, model_json=MODEL, points_csv="x", weld_mod="MODULE weld")

    assert commands(tmp_path) == [
        "truepose validate model.json points.csv",
        "truepose correct model.json weld.mod --out corrected",
    ]


def test_a_cell_file_is_served(tmp_path):
    laid(tmp_path, cell_toml='[robot]\nname = "x"\n[[device]]\nkind = "tracker"\n')

    assert commands(tmp_path) == ["truepose serve --cell cell.toml"]


@pytest.mark.parametrize("text", ["[" * 100_000, "{", "\0", "[1]", '{"format": []}'])
def test_files_of_others_are_passed_over(tmp_path, text):
    laid(tmp_path, any_json=text, any_toml=text, any_zip=text)

    assert len(commands(tmp_path)) == 3


def test_a_folder_that_is_gone_is_an_empty_one(tmp_path):
    assert commands(tmp_path / "gone") == commands(tmp_path)


def test_the_program_says_it_where_no_command_is_named(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "truepose"], cwd=tmp_path, capture_output=True, text=True, env=dict(os.environ)
    )

    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout == introduction(tmp_path)
