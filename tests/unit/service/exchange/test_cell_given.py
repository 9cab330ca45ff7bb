"""A cell by the name that somebody gives: file, robot, scenario, or a sentence."""

from importlib.resources import files

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from truepose.exchange.cells.file import cell_given
from truepose.exchange.errors import InputFileError, UnknownRobotError
from truepose.exchange.models.exports import export

OWN_ROBOT = files("truepose.exchange") / "robots" / "fanuc-lr-mate-200ic.toml"


def test_a_shipped_robot_stands_on_the_usual_table_and_is_nobodys_simulation():
    cell = cell_given("abb-irb-120")

    assert cell.robot.name == "ABB IRB 120"
    assert len(cell.fixed_nests) == len(cell.nests) == 3
    assert cell.simulated is None
    assert cell.devices == ()


def test_a_robot_file_stands_there_too(tmp_path):
    path = tmp_path / "own.toml"
    path.write_bytes(OWN_ROBOT.read_bytes())

    assert cell_given(str(path)).robot.name == "Fanuc LR Mate 200iC"


def test_a_urdf_stands_there_too(tmp_path):
    path = tmp_path / "own.urdf"
    path.write_text(export(model_of(IRB_120), "urdf").text)

    assert cell_given(str(path)).robot.name == "abb_irb_120"


def test_a_scenario_is_its_simulated_cell():
    assert cell_given("lrmate-tilted").simulated.scenario == "lrmate-tilted"


def test_a_cell_file_is_read():
    assert cell_given("docs/examples/networked-cell.toml").devices


def test_a_device_that_can_be_two_things_says_which(tmp_path):
    path = tmp_path / "cell.toml"
    device = '[[device]]\nname = "probe"\ndriver = "heidenhain_nd"\nuse = "linear_gauge"\nport = 4001\n'
    path.write_text(f'robot = "abb-irb-120"\n{device}host = "127.0.0.1"\n')

    (entry,) = cell_given(str(path)).devices

    assert (entry.use, dict(entry.options)) == ("linear_gauge", {"host": "127.0.0.1", "port": 4001})


def test_a_name_that_nobody_knows_lists_the_robots():
    with pytest.raises(UnknownRobotError, match=r"'robbie'.*abb-irb-120"):
        cell_given("robbie")


def test_a_file_that_is_not_there_is_named():
    with pytest.raises(InputFileError, match=r"none\.toml"):
        cell_given("none.toml")
