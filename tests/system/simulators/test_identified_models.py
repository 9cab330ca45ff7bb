"""Identified models in the simulated cell, against the predictions of the program that identified them.

The two are written by different routes (screws and rigid motions here, DH-Modified ports there) and share a
file. What may differ is what either leaves to its iterations: the service stops when torques agree to 1e-5
of the largest, 1 N mm of 1e5, which turns the softest spring here (5e-7 rad/(N mm)) by 5e-7 rad and moves a
nest half a metre away by 0.25 um. It takes small turns about x, y and z as additive where several move one
body (1e-4 rad squared, 0.01 um at a metre), and files round positions to 0.01 um. Each effect moves the tool
by twenty times the limit or more, so that a missing, halved or reversed one could not pass.
"""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import (
    EXTENSIONS,
    ROBOTS,
    extended,
    model_of,
    parameters_of,
    stops_and_nests,
)
from tests.helpers.identification.replays import went_mm
from truepose.domain.identification import Unit
from truepose.effects.registry import EFFECTS
from truepose.exchange.models.file import write_model
from truepose.identification import predict
from truepose_simulators.physics.effects.registry import REALISED
from truepose_simulators.scenarios.model_file import load_model

LIMIT_MM = 1e-3
# Effects that are no part of the arm's equation of motion: they place it.
PLACING = {"axis_parallelism"}
# Of single readings, of a ballbar, of fixed nests: nothing that a tracker would see an arm do.
NOT_OF_A_ROBOT = {"label_swap", "outliers", "ballbar_zero", "fixture_shift", "reference"}
# Described by its cell alone: a model that has one is refused by a sentence that names what is realised.
WITHOUT_A_NAME = {"unnamed"}


@pytest.fixture
def quiet(tmp_path):
    scenario = tmp_path / "quiet.toml"
    scenario.write_text('extends = "irb120-tilted"\nnoise = false\n')
    return str(scenario)


def off_mm(model, scenario, tmp_path, n=60):
    """How far the simulated readings are from the predicted ones, and the predictions, (n,) and (n, 3)."""
    stops, nest = stops_and_nests(model.robot, n)
    predicted, _ = predict(model, stops, nest)
    return np.linalg.norm(went_mm(model, stops, nest, scenario, tmp_path) - predicted, axis=1), predicted


def test_every_effect_that_the_cell_realises_is_tried_here():
    assert {*EXTENSIONS, "compliance"} == {*REALISED, *PLACING}


def test_every_effect_that_the_service_knows_is_realised_or_known_to_be_no_robots():
    placing = {"base", "tool", "geometry", "geometry_dhm", "joint_offset", *PLACING}

    assert set(EFFECTS) == {*REALISED, *placing, *NOT_OF_A_ROBOT, *WITHOUT_A_NAME}


@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("effect", EXTENSIONS)
def test_an_identified_effect_moves_the_simulated_robot_as_predicted(tmp_path, quiet, effect, robot):
    model, without = extended(ROBOTS[robot], effect), extended(ROBOTS[robot])

    off, predicted = off_mm(model, quiet, tmp_path)

    assert off.max() < LIMIT_MM
    stops, nest = stops_and_nests(model.robot)
    moved = np.linalg.norm(predicted - predict(without, stops, nest)[0], axis=1).max()
    assert moved > 20 * LIMIT_MM


@pytest.mark.parametrize(
    "left_out",
    [
        pytest.param({"payload", "link_mass"}, id="all but wrong masses"),
        # The service bends links and base by the stated weights; here they bend by the identified ones.
        pytest.param({"base_compliance", "link_bending"}, id="all but what wrong masses bend"),
    ],
)
@pytest.mark.parametrize("robot", ROBOTS)
def test_effects_act_together_as_predicted(tmp_path, quiet, robot, left_out):
    model = extended(ROBOTS[robot], *(effect for effect in EXTENSIONS if effect not in left_out))

    off, _ = off_mm(model, quiet, tmp_path)

    assert off.max() < LIMIT_MM


def test_springs_of_unknown_masses_act_through_their_products(tmp_path, quiet):
    products = [
        (f"c_{joint}*m{axis}_{frame}", 1e-4 * (-1) ** (joint + frame), "rad*s2/m")
        for joint, frame in ((2, 3), (2, 6), (3, 4), (5, 5))
        for axis in "xy"
    ]
    model = model_of(replace(IRB_120, masses=()), *parameters_of("compliance", products))

    off, _ = off_mm(model, quiet, tmp_path)

    assert off.max() < LIMIT_MM


def test_the_cell_reads_every_unit_that_the_service_writes(tmp_path):
    units = [("base_x", 2.0, unit) for unit in get_args(Unit)]
    write_model(model_of(IRB_120, *parameters_of("base", units)), tmp_path / "model.json")

    # The last of the same name counts; that none is refused is what matters.
    assert load_model(tmp_path / "model.json").parameters["base"].keys() == {"base_x"}
