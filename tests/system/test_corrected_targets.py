"""Corrected targets in the simulated cell: where the robot truly goes, by another route through the physics.

Limits as in `test_simulators_identified_models`, plus 1 um that a correction may leave.
"""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.models import EXTENSIONS, ROBOTS, extended, stops_and_nests
from tests.helpers.identification.replays import went_mm
from truepose.correction import Goals, correct
from truepose.identification.model.estimates import nominal_estimate
from truepose.identification.model.evaluation import Targets, evaluate

LIMIT_MM = 2e-3
# What spoils readings and moves no robot: a replay shows the reading, a correction sends the tool.
OF_THE_INSTRUMENT = {"instrument_scale", "instrument_drift"}


@pytest.fixture
def quiet(tmp_path):
    scenario = tmp_path / "quiet.toml"
    scenario.write_text('extends = "irb120-tilted"\nnoise = false\n')
    return str(scenario)


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize(
    "effects",
    [
        pytest.param(("backlash", "joint_harmonics", "compliance_nonlinear"), id="joints"),
        pytest.param(("link_bending", "base_compliance", "thermal_growth", "axis_parallelism"), id="links"),
        pytest.param(sorted({*EXTENSIONS} - OF_THE_INSTRUMENT - {"payload", "link_mass"}), id="all together"),
    ],
)
def test_a_robot_that_is_its_model_arrives_where_the_nominal_one_would(tmp_path, quiet, effects, robot):
    model = extended(ROBOTS[robot], *effects)
    stops, nest = stops_and_nests(model.robot, 40)
    nominal = nominal_estimate(replace(model, nominal_base=model.base))
    wanted = evaluate(nominal.structure, nominal.values, Targets(stops, nest))
    goals = Goals(stops, nest, wanted.unscaled_mm, wanted.chain.end_rotation)

    found = correct(model, goals)

    there = found.solved
    assert there.mean() > 0.9
    rows = np.flatnonzero(there)
    sent = goals.at(found.joints_rad).taken(rows)
    arrived = went_mm(model, sent, nest[rows], quiet, tmp_path)
    assert np.linalg.norm(arrived - goals.position_mm[rows], axis=1).max() < LIMIT_MM
