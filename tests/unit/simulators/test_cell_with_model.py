"""The simulated cell with an identified robot in the place of its own."""

import numpy as np
import pytest

from tests.unit.simulators.model_documents import model_document, robot_document
from truepose_simulators.__main__ import main
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.robot.open_abb import MotionProgram
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.scenarios.file import load_scenario

SEVENTH = {"joint": 7, "alpha_deg": 90.0, "a_mm": 0.0, "theta_offset_deg": 0.0, "d_mm": 80.0}


@pytest.fixture
def make_cell(load):
    def cell(*parameters, scenario="irb120-clean", seed=1, **changes):
        return Cell(load_scenario(scenario), seed, CellClock(0), load(*parameters, **changes))

    return cell


def with_seventh(**changes):
    robot = robot_document(**changes)
    robot["dhm_nominal"].append(SEVENTH)
    return robot


def test_the_robot_is_the_models_whatever_the_seed_draws(make_cell):
    shift = ("base", "base_x", 7.0, "mm")

    places = [
        cell.true_positions(cell.conditions_now())[0, 0]
        for cell in (make_cell(shift, seed=seed) for seed in (1, 2))
    ]

    assert places == [pytest.approx([374.0 + 7.0 + 125.0, 0.0, 630.0], abs=1e-9)] * 2


def test_an_everyday_scenario_lends_its_tracker_and_air_but_no_effects(make_cell):
    cell = make_cell(scenario="irb120-everyday")

    assert cell.planted.changes == ()
    assert not cell.planted


def test_changes_that_a_scenario_plants_come_on_top(make_cell):
    cell = make_cell(("joint_gain", "gain_2", 1e-3, "1"))
    conditions = cell.conditions(np.full((1, 6), 0.5), np.zeros((1, 6)), np.zeros(1), np.ones(1))
    before = cell.rest(conditions).angles_rad

    cell.plant_change(PlantedChange("joint_gain", "joint 2", 2e-3))

    # The wind-up by the changed load is a thousand times smaller than the gain itself.
    assert cell.rest(conditions).angles_rad[0, 1] - before[0, 1] == pytest.approx(1e-3, rel=1e-2)


def test_the_tracker_stands_where_the_model_says(make_cell):
    cell = make_cell(instrument_in_world_mm=[3000.0, 100.0, 800.0])

    # The tripod stands there as well as anybody puts it: 5 mm per axis, five of these.
    assert cell.tracker.frame[:3, 3] == pytest.approx([3000.0, 100.0, 800.0], abs=25.0)


def test_three_nests_face_where_the_scenarios_do_and_others_everywhere(make_cell):
    three = [{"nest": k, "centre_mm": [10.0 * k, 0.0, 125.0]} for k in (1, 2, 3)]

    assert make_cell(tool_nests=three).scenario.tool.acceptance_deg == 30.0
    assert make_cell(tool_nests=three[:2]).scenario.tool.acceptance_deg == 180.0


def test_home_is_brought_into_the_limits_of_the_models_robot(make_cell):
    limits = [[-90.0, 90.0], [10.0, 90.0], *[[-90.0, 90.0]] * 4]

    home = make_cell(robot=robot_document(joint_limits_deg=limits)).robot.target_rad

    assert np.degrees(home) == pytest.approx([0.0, 10.0, 0.0, 0.0, 0.0, 0.0])


def test_a_robot_of_seven_joints_stands_in_the_cell(make_cell):
    cell = make_cell(robot=with_seventh())

    assert cell.true_positions(cell.conditions_now()).shape == (1, 1, 3)


def test_gaps_in_the_proportions_of_six_joints_are_not_planted_in_seven(make_cell):
    cell = make_cell(robot=with_seventh())

    with pytest.raises(ScenarioError, match='"joints" has the proportions of an arm of 6 joints'):
        cell.plant_change(PlantedChange("backlash", "joints", 0.03))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"robot": with_seventh()}, "ABB IRB 120 has 7 joints, but open_abb moves 6"),
        (
            {"robot": robot_document(masses=[]), "torques_measured": True},
            "identified from torque sensors and the model states no masses",
        ),
        ({"effects": ["outliers"]}, "effect outliers: the simulator does not know this effect"),
    ],
)
def test_a_model_that_cannot_be_driven_is_refused_before_anything_listens(
    write_model, capsys, changes, sentence
):
    model = write_model(model_document(**changes))

    assert main(["irb120-clean", "--model", str(model)]) == 2

    said = capsys.readouterr()
    assert sentence in said.err
    assert (said.out, said.err.count("\n")) == ("", 1)


async def test_a_controller_says_any_name_in_its_own_letters(make_cell):
    cell = make_cell(robot=robot_document(name="KUKA * Größe \n" + 80 * "x"))

    reply = await MotionProgram(cell).answer(b"98 #")

    assert reply is not None
    assert reply.endswith(b"*KUKA ? Gr??e ?" + 16 * b"x")
