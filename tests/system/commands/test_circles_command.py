"""`truepose circles` as a shop calls it: document, table, report, status, sentences."""

import json
import re

import numpy as np
import pytest

from tests.helpers.commands import installed, typed
from tests.helpers.domain.circles import read_on, there_and_back, turned
from tests.helpers.domain.robots import IRB_120
from truepose.exchange.tables.points import point_text

_ANGLES = there_and_back(-80, 80, 8)


def circles(*arguments, status=0, run=typed):
    done = run("circles", *arguments, "--robot", "abb-irb-120")
    assert done.returncode == status, done.stderr
    return done


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    """Joint 1 is perfect; joint 2 is off by a cosine of its angle, and has backlash."""
    joints = np.vstack([turned(1, _ANGLES), turned(2, _ANGLES)])
    stands, below = joints.copy(), len(_ANGLES)
    direction = np.sign(np.diff(_ANGLES, prepend=-79))
    stands[below:, 1] += 1e-3 * np.cos(joints[below:, 1]) - 1e-4 * direction
    file = tmp_path_factory.mktemp("circles") / "points.csv"
    read = read_on(IRB_120, joints, true_rad=stands, scatter_mm=0.01)
    file.write_text(point_text(read), encoding="utf-8")
    return file


def test_the_document_has_the_columns_of_the_table(points):
    document = json.loads(circles(points, "--json", run=installed).stdout)

    first, second = document["circles"]
    assert (first["joint"], first["noise_alone"]) == (1, True)
    assert (second["joint"], second["noise_alone"]) == (2, False)
    assert second["interval_deg"] == pytest.approx([-80.0, 80.0])
    assert second["increment_deg"] == pytest.approx(8.0)
    # 1 - cos(80 deg) of a milliradian, and the backlash; the rest is scatter
    assert second["angular_range_deg"]["value"] == pytest.approx(0.0573 * 0.826 + 0.0115, abs=0.005)
    gap = second["backlash_deg"]
    assert gap["value"] == pytest.approx(0.01146, abs=4.0 * gap["standard_uncertainty"])
    assert len(second["stops"]["tangential_mm"]) == len(_ANGLES)
    assert document["withheld"] == []


def test_the_sentences_say_what_is_wrong_and_what_is_not(points):
    said = circles(points).stdout

    assert "Joint 1, nest 1: No significant error" in said
    assert "Joint 2, nest 1: Tangential errors of 0." in said
    assert max(map(len, said.split("Joint 1, nest 1")[0].splitlines())) <= 80


def test_the_report_has_a_figure_for_each_joint(points, tmp_path):
    report = tmp_path / "circles.html"

    circles(points, "--report", report, "--language", "fr")

    text = report.read_text(encoding="utf-8")
    figures = re.findall(r"<figure>.*?</figure>", text, re.S)
    assert ["<svg" in figure for figure in figures] == [True] * 3  # the front page has one, each joint one
    assert "Axe 2, nid 1" in text
    assert "en montant" in text
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)


def test_a_short_arc_is_refused_in_a_sentence_with_status_1(tmp_path):
    file = tmp_path / "short.csv"
    read = read_on(IRB_120, turned(3, there_and_back(-1, 1, 0.2)), scatter_mm=0.01)
    file.write_text(point_text(read), encoding="utf-8")

    said = circles(file, status=1).stdout

    assert "Joint 3, nest 1: An arc of 2 deg is too short" in said


def test_points_of_a_campaign_are_refused_with_status_2(tmp_path):
    file = tmp_path / "points.csv"
    joints = np.random.default_rng(1).uniform(-1.0, 1.0, (30, 6))
    file.write_text(point_text(read_on(IRB_120, joints)), encoding="utf-8")

    assert "move one joint at a time" in circles(file, status=2).stderr
