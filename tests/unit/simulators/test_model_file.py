import json
from pathlib import Path

import numpy as np
import pytest

from tests.unit.simulators.model_documents import AT_THE_WORLD, robot_document
from truepose_simulators.errors import ModelError
from truepose_simulators.scenarios.model_file import load_model


def test_angles_come_out_of_the_file_in_radians(load):
    model = load(
        ("geometry", "theta_2", 90.0, "deg"),
        ("geometry", "a_3", 0.25, "mm"),
        ("base_drift", "drift_linear_rx", 180.0, "deg/h"),
        base_in_world={**AT_THE_WORLD, "x_mm": 10.0, "rz_deg": 90.0},
    )

    assert model.table.rows[1].alpha_rad == pytest.approx(-np.pi / 2)
    assert model.parameters["geometry"] == pytest.approx({"theta_2": np.pi / 2, "a_3": 0.25})
    assert model.parameters["base_drift"]["drift_linear_rx"] == pytest.approx(np.pi)
    assert model.base[:3, 0] == pytest.approx([0.0, 1.0, 0.0])
    assert model.base[:3, 3] == pytest.approx([10.0, 0.0, 0.0])


def test_what_older_files_lack_is_as_if_it_were_nothing(load):
    model = load(repeatability_mm=None)

    assert (model.origin_s, model.repeatability_mm, model.sensed_torques) == (0.0, 0.0, False)
    assert model.table.limits_rad is None


def test_keys_of_later_programs_are_passed_over(load):
    robot = robot_document(colour="orange", joint_limits_deg=[[-165, 165]] * 6)

    model = load(robot=robot, origin_s=12.5, mood="good")

    assert model.origin_s == 12.5
    assert model.table.limits_rad == pytest.approx(np.radians([[-165, 165]] * 6))


def test_effects_without_parameters_are_kept_so_that_they_can_be_refused(load):
    assert load(effects=["label_swap"]).parameters == {"label_swap": {}}


def with_third_joint(**changes):
    robot = robot_document()
    robot["dhm_nominal"][2] |= changes
    return robot


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"format": "something"}, 'not a model file; one begins with "format": "truepose-model"'),
        ({"version": 2}, "has version 2, but this simulator reads up to 1; update truepose"),
        ({"version": "one"}, 'key "version" must be a whole number'),
        ({"gravity_m_s2_world": [0, 0]}, 'key "gravity_m_s2_world" must have 3 entries, not 2'),
        ({"gravity_m_s2_world": None}, 'key "gravity_m_s2_world" is missing'),
        ({"tool_nests": []}, 'key "tool_nests" must list nests 1, 2, ... in order'),
        ({"tool_nests": [{"nest": 2, "centre_mm": [0, 0, 0]}]}, "must list nests 1, 2, ... in order"),
        ({"tool_nests": 3}, 'key "tool_nests" must be a list'),
        ({"robot": []}, "robot.json: robot must be a table of keys"),
        ({"robot": robot_document(dhm_nominal=[])}, 'key "dhm_nominal" must list joints 1, 2, ... in order'),
        ({"robot": robot_document(dhm_nominal=[{"joint": 1}])}, 'number 1: key "alpha_deg" is missing'),
        ({"robot": robot_document(gear_ratio=[100.0])}, '"gear_ratio" must have 6 entries, one per joint'),
        ({"robot": robot_document(joint_limits_deg=[[1, 2]])}, '"joint_limits_deg" must have 6 entries'),
        (
            {"robot": robot_document(masses=[{"frame": 7, "kg": 1.0, "cog_mm": [0, 0, 0]}])},
            'key "frame" of a mass must be 1 to 6',
        ),
        ({"base_in_world": {**AT_THE_WORLD, "x_mm": "far"}}, 'base_in_world: key "x_mm" must be a number'),
        ({"effects": "geometry"}, 'key "effects" must be a list'),
        ({"robot": with_third_joint(sign=0)}, 'key "sign" of a joint must be 1 or -1'),
        ({"robot": with_third_joint(beta_deg=0.01)}, "joint 3 has a nominal beta"),
    ],
)
def test_a_file_that_cannot_be_meant_is_refused_by_key(load, changes, sentence):
    with pytest.raises(ModelError) as refused:
        load(**changes)

    assert sentence in str(refused.value)
    assert "robot.json" in str(refused.value)


@pytest.mark.parametrize(
    ("value", "unit", "sentence"),
    [
        (1.0, "inch", 'the unit "inch" of a_2 is not one of mm, rad'),
        (float("nan"), "mm", 'parameters number 1: key "value" must be a finite number'),
    ],
)
def test_a_parameter_that_means_nothing_is_refused(load, value, unit, sentence):
    with pytest.raises(ModelError, match=sentence):
        load(("geometry", "a_2", value, unit))


@pytest.mark.parametrize("content", [b"", b"{", b"\xff\xfe", b"[" * 100_000])
def test_a_file_that_is_cut_off_or_no_json_is_refused(tmp_path, content):
    (tmp_path / "robot.json").write_bytes(content)

    with pytest.raises(ModelError, match=r"robot\.json is not a model file: it is cut off, or not JSON"):
        load_model(tmp_path / "robot.json")


def test_a_file_that_was_edited_is_refused_and_named(write_model):
    vector = json.loads(Path("tests/vectors/model_digest.json").read_text(encoding="utf-8"))
    as_written = vector["document"] | {"digest": vector["digest"]}

    with pytest.raises(ModelError, match='key "tool_nests" is missing'):
        load_model(write_model(as_written))
    with pytest.raises(ModelError, match=r"robot\.json was edited after truepose wrote it"):
        load_model(write_model(as_written | {"values": [1e-07, 0.2, -0.0, 1e22, True]}))


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ModelError, match="cannot be read: No such file"):
        load_model(tmp_path / "robot.json")
