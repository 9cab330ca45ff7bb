"""Circle and sphere tests in a notebook: the numbers of the judges, in tables, sentences and reports."""

import re

import numpy as np
import pytest

import truepose as tp
from tests.helpers.ballbar.spheres import knowing, longer, sphere_campaign
from tests.helpers.domain.circles import read_on, there_and_back, turned
from tests.helpers.domain.robots import IRB_120
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.models.file import write_model
from truepose.exchange.tables.points import point_text

_ANGLES = there_and_back(-60, 60, 10)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A sphere test of an arm whose upper arm is too long, the model that knows it, and a circle test."""
    folder = tmp_path_factory.mktemp("tests")
    write_campaign(sphere_campaign(longer(), noise=1.0, per_nest=15), folder / "sphere")
    write_model(knowing(), folder / "robot.json")
    points = point_text(read_on(IRB_120, turned(2, _ANGLES), scatter_mm=0.01))
    (folder / "circle.csv").write_text(points, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def sphere(folder):
    """The sphere test with the model."""
    return tp.sphere(folder / "sphere", {"laser": folder / "robot.json"})


@pytest.fixture(scope="module")
def circles(folder):
    """The circle test."""
    return tp.circles(folder / "circle.csv", "abb-irb-120")


def test_a_sphere_test_names_its_models_in_their_order(sphere):
    assert re.fullmatch(
        r"Sphere test of ABB IRB 120: 30 lengths; laser RMS 0\.\d+ mm; nominal RMS 0\.\d+ mm", repr(sphere)
    )
    assert [one["model"] for one in sphere.document["order"]] == ["laser", "nominal"]
    assert "Accuracy, best first: laser" in sphere._repr_html_()


def test_a_sphere_test_has_a_row_for_each_nest_model_and_centre(sphere):
    table = sphere.to_frame()

    assert len(table) == 2 * 2 * 2
    assert set(table["model"]) == {"nominal", "laser"}
    assert table["n"].tolist() == [15] * 8


def test_reports_are_those_of_the_commands(sphere, circles, tmp_path):
    sphere.report(tmp_path / "sphere.html")
    circles.report(tmp_path / "circles.html")

    assert "Sphere test of ABB IRB 120" in (tmp_path / "sphere.html").read_text(encoding="utf-8")
    assert "Circle test of ABB IRB 120" in (tmp_path / "circles.html").read_text(encoding="utf-8")


def test_no_model_is_called_as_the_robots_own(folder):
    with pytest.raises(ConfigurationError, match="The name 'nominal' is reserved for the nominal model"):
        tp.sphere(folder / "sphere", {"nominal": folder / "robot.json"})


def test_a_circle_test_tells_every_stop(circles):
    table = circles.to_frame()

    assert repr(circles) == "Circle test of ABB IRB 120: 1 circle, 0 withheld"
    assert len(table) == len(_ANGLES)
    assert table["angle_deg"].to_numpy() == pytest.approx(np.asarray(_ANGLES, dtype=float), abs=1e-6)
    assert circles.document["circles"][0]["joint"] == 2
    assert "Joint 2, nest 1: No significant error" in circles._repr_html_()


def test_a_circle_test_takes_the_robot_of_a_model(folder, circles):
    by_model = tp.circles(folder / "circle.csv", tp.read_model(folder / "robot.json"))

    assert by_model.document == circles.document


@pytest.mark.parametrize("robot", [None, 7])
def test_a_robot_that_is_none_is_refused(folder, robot):
    with pytest.raises(ConfigurationError, match="give the name of a shipped robot"):
        tp.circles(folder / "circle.csv", robot)


def test_lengths_are_no_circle_test(folder):
    with pytest.raises(ConfigurationError, match="a circle test needs positions"):
        tp.circles(folder / "sphere" / "legs.csv", "abb-irb-120")
