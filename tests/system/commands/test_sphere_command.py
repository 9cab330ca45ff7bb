"""`truepose sphere` as a shop calls it: folder, document, report, status, sentences."""

import json
import re
from dataclasses import replace

import pytest

from tests.helpers.ballbar.spheres import knowing, longer, sphere_campaign
from tests.helpers.commands import installed, typed
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.models.file import write_model


def sphere(*arguments, status=0, run=typed):
    done = run("sphere", *arguments)
    assert done.returncode == status, done.stderr
    return done


@pytest.fixture(scope="module")
def campaign():
    """A sphere test of an arm whose upper arm is 0.2 mm longer than its table says."""
    return sphere_campaign(longer(), noise=1.0, per_nest=20)


@pytest.fixture(scope="module")
def folder(campaign, tmp_path_factory):
    """It, and the model that knows the upper arm."""
    folder = tmp_path_factory.mktemp("sphere")
    write_campaign(campaign, folder / "test")
    write_model(knowing(), folder / "robot.json")
    return folder


def test_the_document_has_the_models_in_their_order(folder):
    document = json.loads(sphere(folder / "test", "--model", folder / "robot.json", "--json").stdout)

    assert [one["model"] for one in document["order"]] == ["robot", "nominal"]
    (ball,) = document["spheres"]
    errors = {(one["model"], one["centre"]): one for one in ball["errors"]}
    assert errors["robot", "taught"]["noise_alone"]
    assert not errors["nominal", "best"]["noise_alone"]
    assert [one["nest"] for one in errors["nominal", "taught"]["figures"]] == [1, 2, None]
    assert len(errors["nominal", "taught"]["error_mm"]) == len(ball["config"]) == 40


def test_the_sentences_say_what_is_wrong_and_what_is_not(folder):
    said = sphere(folder / "test", "--model", folder / "robot.json", run=installed).stdout

    assert "Accuracy, best first: robot (RMS" in said
    assert "robot, about the best-fit centre: no significant error" in " ".join(said.split())
    assert "nominal, about the taught centre: errors of up to" in " ".join(said.split())


def test_the_report_has_a_figure_for_the_ball(folder, tmp_path):
    report = tmp_path / "sphere.html"

    sphere(folder / "test", "--report", report, "--language", "fr")

    text = report.read_text(encoding="utf-8")
    figures = re.findall(r"<figure>.*?</figure>", text, re.S)
    assert ["<svg" in figure for figure in figures] == [True] * 2  # the front page has one, the ball one
    assert "erreurs radiales" in text
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)


def test_a_ball_whose_place_stays_open_is_said_with_status_1(tmp_path):
    write_campaign(sphere_campaign(per_nest=8, nests=(1,), reach_rad=0.05), tmp_path / "narrow")

    said = " ".join(sphere(tmp_path / "narrow", status=1).stdout.split())

    assert "the configurations lie near one plane or one line" in said


def test_lengths_in_another_unit_are_refused_with_status_2(campaign, tmp_path):
    legs = replace(campaign.legs, length_mm=1e-3 * campaign.legs.length_mm)
    write_campaign(replace(campaign, legs=legs), tmp_path / "metres")

    assert "Check the ballbar and the unit" in " ".join(sphere(tmp_path / "metres", status=2).stderr.split())


def test_two_models_of_one_name_are_refused(folder):
    model = folder / "robot.json"

    refused = sphere(folder / "test", "--model", model, "--model", model, status=2)

    assert "give each file a different name" in " ".join(refused.stderr.split())
