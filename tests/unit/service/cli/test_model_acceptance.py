"""What commands accept of a model file: one that moves the tool far, or was edited, is not believed."""

import json
import math

import pytest

from tests.helpers.commands import typed as truepose
from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, parameters_of, registered
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
def typed(tmp_path):
    """Types a command on a model file of this text."""
    (tmp_path / "targets.csv").write_text(TARGETS)
    (tmp_path / "points.csv").write_text(POINTS)

    def type_command(command, text, *options):
        (tmp_path / "robot.json").write_text(text, encoding="utf-8")
        table = {"correct": "targets.csv", "predict": "points.csv"}.get(command)
        files = [tmp_path / "robot.json", *([] if table is None else [tmp_path / table])]
        done = truepose(command, *files, "--out", tmp_path / "out.csv", *options)
        return done.returncode, (tmp_path / "out.csv").exists(), done

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
    assert said.stderr.startswith("robot.json: the model moves the tool of ABB IRB 120 by up to ")
    assert size in said.stderr
    assert f"far from their priors: {FAR[name].name} = " in said.stderr
    assert "--max-shift-mm" in said.stderr


def test_whoever_states_the_shift_has_it_accepted(typed):
    status, written, said = typed(
        "correct", model_text(far_model("joint")), "--max-shift-mm", "1500", "--json"
    )

    assert (status in {0, 1}, written) == (True, True)
    assert 100.0 < json.loads(said.stdout)["model_file"]["largest_shift_mm"] < 1500.0


def test_a_smaller_limit_refuses_what_the_usual_one_lets_through(typed):
    text = model_text(NEAR)

    assert typed("correct", text)[:2] == (0, True)
    status, _, said = typed("correct", text, "--max-shift-mm", "0.01")
    assert status == 2
    assert "and up to 0.01 mm is accepted" in said.stderr


WORN = model_of(IRB_120, Parameter("d_4", "geometry", 9.0, "mm", 0.01, 2.0), base=STANDS)
EDITED = "key digest: the model was edited after truepose wrote it"


@pytest.mark.parametrize(
    ("command", "text", "answer", "sentence"),
    [
        ("predict", model_text(far_model("joint")), (0, True), "The model moves the tool by up to"),
        (
            "predict",
            without_digest(model_text(far_model("joint"))),
            (2, False),
            "the model moves the tool of ABB IRB 120",
        ),
        ("correct", edited(model_text(NEAR)), (2, False), EDITED),
        ("predict", edited(model_text(NEAR)), (2, False), EDITED),
        ("correct", model_text(WORN), (0, True), "more than the usual 5 mm"),
        ("correct", without_digest(model_text(WORN)), (2, False), "and up to 5 mm is accepted"),
    ],
    ids=[
        "predicts far", "predicts far, no digest", "corrects, edited", "predicts, edited",
        "corrects what was measured to be far off", "nothing vouches for the same shift",
    ],
)  # fmt: skip
def test_what_is_believed_depends_on_who_vouches_for_the_file(typed, command, text, answer, sentence):
    status, written, said = typed(command, text)

    assert (status, written) == answer
    assert sentence in said.stderr


def test_values_far_from_their_priors_are_remarked_on_where_the_shift_is_small(typed):
    far = model_of(IRB_120, Parameter("theta_2", "geometry", 1e-3, "rad", 1e-6, 1e-5), base=STANDS)

    status, _, said = typed("predict", model_text(far))

    assert status == 0
    assert "Some model values are far from their priors" in said.stderr
    assert "The model moves the tool" not in said.stderr


@pytest.mark.parametrize(
    ("text", "options", "digest", "sentence"),
    [
        (
            edited(model_text(NEAR)),
            ("--accept-edited",),
            "edited",
            "The model file was edited after truepose wrote it",
        ),
        (without_digest(model_text(NEAR)), (), "no digest", "The model file has no digest"),
    ],
    ids=["edited, and somebody says so", "from before there were digests"],
)
def test_a_file_that_is_not_as_it_was_written_is_used_and_that_is_said(
    typed, text, options, digest, sentence
):
    status, _, said = typed("correct", text, *options, "--json")

    assert status == 0
    assert json.loads(said.stdout)["model_file"]["digest"] == digest
    assert sentence in said.stderr
