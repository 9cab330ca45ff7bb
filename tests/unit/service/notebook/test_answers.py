"""Answers in a notebook: the command line's numbers, short to read, to be drawn, kept and worked on."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

import truepose as tp
from tests.helpers.commands import typed
from tests.unit.service.notebook.conftest import EXAMPLES
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot

_HELD_OUT = EXAMPLES / "campaign" / "validation.csv"


def _command(*arguments):
    return typed(*arguments).stdout


@pytest.fixture(scope="module")
def model_file(model, tmp_path_factory):
    file = tmp_path_factory.mktemp("model") / "robot.json"
    model.save(file)
    return file


def test_documents_are_those_of_the_commands(campaign, identified, model, model_file):
    folder = EXAMPLES / "campaign"

    assert identified.document == json.loads(_command("identify", folder, "--json"))
    assert tp.diagnose(campaign).document == json.loads(_command("diagnose", folder, "--json"))
    judged = json.loads(_command("validate", model_file, _HELD_OUT, "--json", "--limit-mm", "0.1"))
    assert judged.pop("model_file")["digest"] == "intact"
    assert tp.validate(model, _HELD_OUT, limit_mm=0.1).document == judged


def test_predictions_are_those_of_the_command(model, model_file, tmp_path):
    _command("predict", model_file, _HELD_OUT, "--out", tmp_path / "command.csv")

    tp.predict(model, _HELD_OUT).save(tmp_path / "notebook.csv")

    assert (tmp_path / "notebook.csv").read_bytes() == (tmp_path / "command.csv").read_bytes()


def test_a_saved_model_predicts_the_same(model, model_file):
    again = tp.read_model(model_file)

    assert again.document == model.document
    assert tp.predict(again, _HELD_OUT).position_mm == pytest.approx(tp.predict(model, _HELD_OUT).position_mm)


def test_rows_without_a_nest_are_predicted_for_every_nest(model):
    predicted = tp.predict(model, {"config": [7], "joints_rad": [[0.1] * 6]})

    assert predicted.nest.tolist() == [1, 2, 3]
    assert predicted.config.tolist() == [7, 7, 7]


def test_a_hidden_wave_is_named_from_frames_alone(diagnosed):
    """Neither base nor nests are stated; the truth is 0.03 deg, two periods per turn of joint 4."""
    (finding,) = diagnosed.answer.findings

    assert (diagnosed.verdict, finding.effect, finding.subject) == ("explained", "joint_harmonics", "joint 4")
    # Four of its own standard uncertainties, which at 0.015 mm over 80 readings are some 0.001 deg.
    assert finding.amplitude == pytest.approx(0.03, abs=4.0 * finding.amplitude_standard_uncertainty)
    assert finding.amplitude_standard_uncertainty < 0.002
    assert "explained, 1 finding (joint_harmonics of joint 4)" in repr(diagnosed)


def test_nothing_is_found_where_nothing_is_hidden(campaign):
    diagnosed = tp.diagnose(campaign)

    assert (diagnosed.verdict, diagnosed.answer.findings) == ("consistent", ())
    assert "consistent, no finding" in repr(diagnosed)
    with pytest.raises(ConfigurationError, match=r"There is no finding 1: the diagnosis has no finding\."):
        diagnosed.plot(1)


def test_where_nothing_can_be_fitted_there_is_an_answer_and_no_model(campaign):
    few = {"config": [1, 2], "joints_deg": np.eye(2, 6), "nest": 1, "position_mm": np.eye(2, 3), "u_mm": 0.01}

    answer = tp.identify(tp.read_campaign(few, robot="abb-irb-120"))

    assert (answer.status, answer.model, answer.plot()) == ("too_few_data", None, None)
    assert "too_few_data; 2 configurations, no parameter" in repr(answer)
    assert "too few" in answer._repr_html_().lower() or answer.message in answer._repr_html_()


def _shown(answers):
    return {type(answer).__name__: answer for answer in answers}


@pytest.fixture(scope="module")
def answers(campaign, identified, model, diagnosed):
    plan = tp.plan(EXAMPLES / "networked-cell.toml", 3, role="validation")
    judged, predicted = tp.validate(model, _HELD_OUT), tp.predict(model, _HELD_OUT)
    return _shown((campaign, identified, model, diagnosed, judged, predicted, plan))


@pytest.mark.parametrize("name", ["Identification", "Diagnosis", "Validation"])
def test_a_result_begins_with_its_outcome(answers, name):
    assert answers[name]._repr_html_().startswith("<div><p>Mean error ")


@pytest.mark.parametrize(
    "name", ["Campaign", "Identification", "Model", "Diagnosis", "Validation", "Predictions", "Plan"]
)
def test_an_answer_is_short_and_has_a_table(answers, name):
    pandas = pytest.importorskip("pandas")

    frame = answers[name].to_frame()

    assert len(repr(answers[name])) < 250
    assert "\n" not in repr(answers[name])
    assert isinstance(frame, pandas.DataFrame)
    assert len(frame) > 0
    assert answers[name]._repr_html_().startswith("<div><p>")


@pytest.mark.parametrize("name", ["Identification", "Diagnosis", "Validation"])
def test_a_plot_is_a_figure_of_matplotlib_that_may_be_changed(answers, name, tmp_path):
    figure = answers[name].plot()

    figure.axes[0].set_title("left arm")
    figure.savefig(tmp_path / "errors.png")

    assert (tmp_path / "errors.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("what", "axis"),
    [
        ("distances", "measured minus predicted distance [mm]"),
        ("places", "distance from the centre of the zone [mm]"),
    ],
)
def test_a_validation_draws_distances_and_places(model, what, axis):
    figure = tp.validate(model, _HELD_OUT).plot(what)

    assert figure.axes[0].get_xlabel() == axis


def test_one_reading_has_no_distances_to_draw(model):
    row = {
        "config": [1],
        "joints_rad": [[0.1] * 6],
        "nest": 1,
        "position_mm": [[300.0, 0.0, 600.0]],
        "u_mm": 0.01,
    }

    with pytest.raises(ConfigurationError, match="There are no distance errors"):
        tp.validate(model, row).plot("distances")


def test_cycles_are_a_test_of_iso_9283(model):
    poses = [[0.2 * k, 0.1 * k, -0.1, 0.1, 0.3, 0.0] for k in (-2, -1, 1, 2, 0)]
    joints = np.tile(poses, (30, 1))
    places = tp.predict(model, {"config": np.arange(150), "joints_rad": joints, "nest": 1}).position_mm
    points = {
        "config": np.tile(np.arange(5), 30),
        "joints_rad": joints,
        "nest": 1,
        "position_mm": places,
        "u_mm": 0.01,
    }

    judged = tp.validate(model, points, iso9283=True)

    figures = judged.document["iso9283"]["figures"]
    assert {f["symbol"] for f in figures} == {"AP", "RP", "AD", "RD"}
    assert max(abs(f["value"]) for f in figures if f["commanded_by"] != "nominal") < 1e-9
    assert "Five poses do not prove accuracy" in judged._repr_html_()
    assert "iso9283" not in tp.validate(model, points).document


def test_a_finding_is_drawn_with_its_curve(diagnosed):
    axes = diagnosed.plot(1).axes[0]

    assert axes.get_xlabel() == "angle of joint 4 [deg]"


def test_names_from_files_are_escaped(identified):
    robot = replace(identified.campaign.robot, name="<script>alert(1)</script>")

    page = tp.Identification(identified.answer, replace(identified.campaign, robot=robot))._repr_html_()

    assert isinstance(robot, Robot)
    assert "<script>" not in page
    assert "&lt;script&gt;" in page


def test_a_plan_is_that_of_the_service_and_repeats_itself():
    cell = EXAMPLES / "networked-cell.toml"

    first, second, other = (tp.plan(cell, 4, role="validation", seed=seed) for seed in (1, 1, 2))

    assert np.array_equal(first.joints_rad, second.joints_rad)
    assert not np.array_equal(first.joints_rad, other.joints_rad)
    with pytest.raises(ConfigurationError, match=r"n must be at least 1 \(got 0\)"):
        tp.plan(cell, 0)


def test_a_plan_to_calibrate_visits_some_again():
    plan = tp.plan(EXAMPLES / "networked-cell.toml", 12, seed=3)

    assert repr(plan) == "Plan of a calibration of ABB IRB 120: 12 configurations, 5 repeat measurements"
    assert (plan.repeat_of[:12] == -1).all()


def test_a_plan_to_calibrate_promises_an_accuracy_and_draws_it(tmp_path):
    pandas = pytest.importorskip("pandas")

    plan = tp.plan("abb-irb-120", 30)

    assert plan.promise.promised.n == 30
    assert "Predicted mean error with 30 configurations" in plan._repr_html_()
    frame = plan.curve_to_frame()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame["n"]) == sorted(frame["n"])
    assert frame["mean_mm"].is_monotonic_decreasing
    plan.plot().savefig(tmp_path / "curve.png")
    assert (tmp_path / "curve.png").stat().st_size > 5000


def test_without_a_number_a_calibration_has_as_many_as_the_knee_says():
    plan = tp.plan("abb-irb-120")

    assert (plan.repeat_of == -1).sum() == plan.promise.advised


def test_a_validation_promises_nothing_and_needs_a_number(answers):
    assert answers["Plan"].promise is None
    assert answers["Plan"].plot() is None
    with pytest.raises(ConfigurationError, match="To plan a validation, give the number"):
        tp.plan(EXAMPLES / "networked-cell.toml", role="validation")


def test_without_pandas_a_frame_says_what_to_install(identified, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)

    with pytest.raises(tp.TrueposeError, match=r"pip install 'truepose\[notebook\]'"):
        identified.to_frame()


@pytest.mark.parametrize("limit_mm", [0.0, -1.0, float("nan"), float("inf")])
def test_a_limit_that_is_no_length_is_refused(model, limit_mm):
    with pytest.raises(
        ConfigurationError, match="limit_mm, the largest acceptable error, must be greater than 0 mm"
    ):
        tp.validate(model, _HELD_OUT, limit_mm=limit_mm)


def test_what_rows_do_not_tell_is_remarked(model):
    judged = tp.validate(model, _HELD_OUT)

    assert judged.remarks == ()
    assert tp.predict(model, {"config": [1], "joints_deg": [[0.0] * 6], "shift": ["late"]}).remarks == (
        "points: column shift is not part of the format and is ignored.",
    )


def test_corrected_targets_are_read_back_as_they_were_saved(model, tmp_path):
    poses = {
        "target": ["a", "b"],
        "position_mm": [[350, 100, 400], [9000, 0, 0]],
        "qw": 0,
        "qx": 0,
        "qy": 1,
        "qz": 0,
    }

    corrected = tp.correct(model, poses)
    corrected.save(tmp_path / "out.csv")

    assert corrected.status == ["ok", "out_of_reach"]
    assert np.isfinite(corrected.joints_deg[0]).all()
    assert np.isnan(corrected.joints_deg[1]).all()
    assert repr(corrected) == "1 of 2 targets corrected."
    rows = (tmp_path / "out.csv").read_text().splitlines()
    assert [row.split(",")[0] for row in rows] == ["target", "a", "b"]
    assert "out_of_reach" in corrected._repr_html_()


def test_targets_in_inches_are_refused_unless_they_are_meant_as_they_stand(model):
    places = np.array([[350, 100, 400], [330, 150, 420], [300, -200, 450], [380, 50, 350]]) / 25.4
    poses = {"position_mm": places, "qw": [0.0] * 4, "qx": [0.0] * 4, "qy": [1.0] * 4, "qz": [0.0] * 4}

    with pytest.raises(ConfigurationError, match="inches"):
        tp.correct(model, poses)
    assert len(tp.correct(model, poses, as_written=True).status) == 4


def test_targets_in_the_robots_base_go_where_the_model_has_it(model):
    pose = {"position_mm": [[350.0, 100.0, 400.0]], "qw": 0.0, "qx": 0.0, "qy": 1.0, "qz": 0.0}

    world, base = (tp.correct(model, pose, frame=frame).joints_deg for frame in ("world", "base"))

    assert np.abs(world - base).max() > 1e-4
