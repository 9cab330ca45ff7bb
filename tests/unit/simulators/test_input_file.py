"""A simulated cell waits for no pipe and reads no device, whichever file it is given."""

import os

import pytest

from tests.helpers.machine import DEVICE_FILES, NAMED_PIPES
from truepose_simulators.errors import ModelError, ReplayError, ScenarioError
from truepose_simulators.recording.ballbars.plan import read_plan
from truepose_simulators.recording.measured_campaign import read_table
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.model_file import load_model
from truepose_simulators.scenarios.table import read_file, read_text


@NAMED_PIPES
@pytest.mark.parametrize(
    ("read", "error"), [(load_model, ModelError), (read_plan, ScenarioError), (read_table, ReplayError)]
)
def test_a_pipe_is_refused_at_once(tmp_path, read, error):
    os.mkfifo(tmp_path / "it")

    with pytest.raises(error, match="it is not a file but a folder, a pipe or a device"):
        read(tmp_path / "it")


@DEVICE_FILES
def test_a_device_has_no_content(tmp_path):
    (tmp_path / "it").symlink_to("/dev/zero")

    with pytest.raises(OSError, match="not a file but a folder, a pipe or a device"):
        read_file(tmp_path / "it")


def test_a_byte_order_mark_is_no_text(tmp_path):
    (tmp_path / "it").write_bytes(b"\xef\xbb\xbfrobot")

    assert read_text(tmp_path / "it") == "robot"


@pytest.mark.parametrize("text", ["robot = " + "9" * 5000, "robot = " + "[" * 100_000])
def test_toml_that_python_gives_up_on_is_refused_in_one_sentence(tmp_path, text):
    (tmp_path / "it.toml").write_text(text)

    with pytest.raises(ScenarioError, match=r"it.toml is not TOML"):
        load_scenario(str(tmp_path / "it.toml"))


@pytest.mark.parametrize("number", ["nan", "-inf", "1" + "0" * 400])
def test_a_number_without_an_end_is_refused_with_its_key(tmp_path, number):
    (tmp_path / "it.toml").write_text(f'robot = "irb120"\n[tool]\nmass_kg = {number}\n')

    with pytest.raises(
        ScenarioError, match=r'it.toml: \[tool\]: key "mass_kg" must be a finite number'
    ) as told:
        load_scenario(str(tmp_path / "it.toml"))
    assert len(str(told.value)) < 120
