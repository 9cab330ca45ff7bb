"""What commands accept of a model file: one that moves the tool far, or was edited, is not believed."""

import json
import math
import sys

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, parameters_of, registered
from truepose.cli import main
from truepose.domain.identification import Parameter
from truepose.exchange.models.file import model_text

TARGETS = "target,x_mm,y_mm,z_mm,qw,qx,qy,qz\nnear,350,100,400,0,0,1,0\n"
POINTS = "config,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n1,0,10,20,0,30,0\n"
STANDS = model_of().nominal_base
NEAR = registered(model_of(IRB_120, *parameters_of("geometry", [("theta_2", 1e-3, "rad")]), base=STANDS))
FAR = {
    "base": Parameter("base_x", "base", 5000.0, "mm", 0.01, 10.0),
    "joint": Parameter("theta_2", "geometry", math.radians(40.0), "rad", 1e-5, 0.005),
}


def far_model(name):
    return model_of(IRB_120, FAR[name], base=STANDS)


@pytest.fixture
def typed(tmp_path, monkeypatch, capsys):
    """Types a command on a model file of this text."""
    (tmp_path / "targets.csv").write_text(TARGETS)
    (tmp_path / "points.csv").write_text(POINTS)

    def type_command(command, text, *options):
        (tmp_path / "robot.json").write_text(text, encoding="utf-8")
        table = {"correct": "targets.csv", "predict": "points.csv"}.get(command)
        files = [tmp_path / "robot.json", *([] if table is None else [tmp_path / table])]
        line = ["truepose", command, *files, "--out", tmp_path / "out.csv", *options]
        monkeypatch.setattr(sys, "argv", [str(word) for word in line])
        return main(), (tmp_path / "out.csv").exists(), capsys.readouterr()

    return type_command


def without_digest(text):
    document = json.loads(text)
    del document["digest"]
    return json.dumps(document)


def edited(text):
    document = json.loads(text)
    document["robot"]["dhm_nominal"][0]["d_mm"] += 1.0
    return json.dumps(document)


@pytest.mark.parametrize(("name", "size"), [("base", "5000 mm"), ("joint", " mm at ")])
@pytest.mark.parametrize("options", [("correct",), ("export", "--as", "dhm")], ids=["correct", "export"])
def test_a_model_that_moves_the_tool_far_is_refused_where_a_robot_follows_it(typed, name, size, options):
    status, written, said = typed(options[0], model_text(far_model(name)), *options[1:])

    assert (status, written) == (2, False)
    assert said.err.startswith("robot.json: the model moves the tool of ABB IRB 120 by up to ")
    assert size in said.err
    assert f"far from their priors: {FAR[name].name} = " in said.err
    assert "--max-shift-mm" in said.err


def test_whoever_states_the_shift_has_it_accepted(typed):
    status, written, said = typed(
        "correct", model_text(far_model("joint")), "--max-shift-mm", "1500", "--json"
    )

    assert (status in {0, 1}, written) == (True, True)
    assert 100.0 < json.loads(said.out)["model_file"]["largest_shift_mm"] < 1500.0


def test_a_smaller_limit_refuses_what_the_usual_one_lets_through(typed):
    text = model_text(NEAR)

    assert typed("correct", text)[:2] == (0, True)
    status, _, said = typed("correct", text, "--max-shift-mm", "0.01")
    assert status == 2
    assert "and up to 0.01 mm is accepted" in said.err


def test_a_prediction_by_a_file_as_it_was_written_is_remarked_on(typed):
    status, written, said = typed("predict", model_text(far_model("joint")))

    assert (status, written) == (0, True)
    assert "The model moves the tool by up to" in said.err


def test_a_prediction_by_a_far_model_without_a_digest_is_refused(typed):
    status, written, said = typed("predict", without_digest(model_text(far_model("joint"))))

    assert (status, written) == (2, False)
    assert "the model moves the tool of ABB IRB 120" in said.err


@pytest.mark.parametrize("command", ["correct", "predict"])
def test_an_edited_file_is_refused_and_named(typed, command):
    status, written, said = typed(command, edited(model_text(NEAR)))

    assert (status, written) == (2, False)
    assert "key digest: the model was edited after truepose wrote it" in said.err


WORN = model_of(IRB_120, Parameter("d_4", "geometry", 9.0, "mm", 0.01, 2.0), base=STANDS)


def test_an_arm_that_was_measured_to_be_far_off_is_corrected_and_that_is_said(typed):
    status, written, said = typed("correct", model_text(WORN))

    assert (status, written) == (0, True)
    assert "more than the usual 5 mm" in said.err


def test_the_same_shift_is_refused_where_nothing_vouches_for_it(typed):
    status, written, said = typed("correct", without_digest(model_text(WORN)))

    assert (status, written) == (2, False)
    assert "and up to 5 mm is accepted" in said.err


def test_values_far_from_their_priors_are_remarked_on_where_the_shift_is_small(typed):
    far = model_of(IRB_120, Parameter("theta_2", "geometry", 1e-3, "rad", 1e-6, 1e-5), base=STANDS)

    status, _, said = typed("predict", model_text(far))

    assert status == 0
    assert "Some model values are far from their priors" in said.err
    assert "The model moves the tool" not in said.err


def test_an_edited_file_is_used_where_somebody_says_so(typed):
    status, _, said = typed("correct", edited(model_text(NEAR)), "--accept-edited", "--json")

    assert status == 0
    assert json.loads(said.out)["model_file"]["digest"] == "edited"
    assert "The model file was edited after truepose wrote it" in said.err


def test_a_file_from_before_there_were_digests_is_used_and_that_is_said(typed):
    status, _, said = typed("correct", without_digest(model_text(NEAR)), "--json")

    assert status == 0
    assert json.loads(said.out)["model_file"]["digest"] == "no digest"
    assert "The model file has no digest" in said.err
