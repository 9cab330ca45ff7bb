"""New campaigns of an identified robot: what a folder states of it, and what its papers cannot say."""

import numpy as np
import pytest

from tests.unit.simulators.model_documents import robot_document
from truepose_simulators.errors import ModelError
from truepose_simulators.recording import RecordingRequest, record
from truepose_simulators.recording.files import campaign_document
from truepose_simulators.scenarios.file import load_scenario

CLEAN = load_scenario("irb120-clean")
FEW = RecordingRequest(configurations=8, validation=0)


def test_the_papers_are_those_of_the_models_robot(load):
    robot = robot_document(name="ours", gear_ratio=[100.0] * 6)
    robot["dhm_nominal"][1]["sign"] = -1
    model = load(("tool", "nest_1_x", 0.5, "mm"), robot=robot, gravity_m_s2_world=[0.0, 1.0, -9.0])

    document = campaign_document(record(CLEAN, 1, FEW, model).cell, {})

    assert document["robot"] == "ours"
    assert [row.get("sign", 1) for row in document["dhm_nominal"]] == [1, -1, 1, 1, 1, 1]
    assert [row["d_mm"] for row in document["dhm_nominal"]] == [290.0, 0.0, 0.0, 302.0, 0.0, 72.0]
    assert document["masses"] == [{"frame": 4, "kg": 5.0, "cog_mm": [0.0, 0.0, -193.6]}]
    assert document["gravity_m_s2_world"] == [0.0, 1.0, -9.0]
    assert document["gear_ratio"] == [100.0] * 6
    assert "typical_compliance_rad_per_Nmm" not in document  # the model states none, and zero is none
    assert document["base_in_world_nominal"] is None
    assert document["tool_nests_mm"] == [None]  # the model had to find it


def test_stops_stay_in_the_models_own_ranges(load):
    ranges = [[-20.0, 20.0]] * 6

    stops = record(CLEAN, 1, FEW, load(robot=robot_document(calibration_ranges_deg=ranges))).calibration.stops

    assert np.abs(stops.joints_deg).max() <= 20.0


def test_without_ranges_those_of_the_scenarios_robot_are_taken(load):
    stops = record(CLEAN, 1, FEW, load()).calibration.stops

    assert stops.joints_deg[:, 1].min() >= 0.0  # joint 2 of the thesis stays in front


def test_without_any_ranges_nothing_can_be_recorded(load):
    robot = robot_document()
    robot["dhm_nominal"].append({"joint": 7, "alpha_deg": 90.0, "a_mm": 0, "theta_offset_deg": 0, "d_mm": 80})

    with pytest.raises(ModelError, match="neither calibration ranges nor joint limits, and the scenario's"):
        record(CLEAN, 1, FEW, load(robot=robot))
