"""Positions and orientations of every effect, candidates of its own included, against central differences.

Loads are held where derivatives hold them: measured torques stand in the rows, and weights then keep the
levers of the undeflected arm. What remains is smooth, so that central differences at steps of 1e-4 widths
are right to 1e-8 of a derivative; rounding of a metre, 1e-13 mm, comes to 1e-9 mm per width over such steps.
"""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    START,
    scene_of,
    start_for,
    telling_campaign,
    telling_problem,
    telling_scene,
    without_masses,
)
from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.effects.registry import CAUSES, EFFECTS
from truepose.identification.model.derivatives import position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import evaluate
from truepose.identification.problem.build import build
from truepose.kinematics.frames import vector_from_rotation

EXACT = 1e-6
ROUNDING_MM = 1e-9
OF_BALLBARS = {"ballbar_zero", "fixture_shift"}
WITHOUT_PARAMETERS = {"label_swap", "outliers"}
ON_POSITIONS = [name for name in CAUSES if name not in OF_BALLBARS | WITHOUT_PARAMETERS]
MOST = 24  # candidates of a search over a grid, waves of a joint: evenly from the first to the last


def some(many):
    picked = np.unique(np.linspace(0, len(many) - 1, MOST).astype(int))
    return [many[k] for k in picked] if len(many) > MOST else list(many)


def extended(problem, cause, scene):
    """The problem with the parameters of every candidate, each parameter once."""
    candidates = some(CAUSES[cause].candidates(scene))
    specs = {spec.name: spec for candidate in candidates for spec in some(candidate.specs)}
    structure = problem.structure.extended(cause, tuple(specs.values()))
    return replace(problem, structure=structure, start=np.append(problem.start, np.zeros(len(specs))))


def displaced(problem, seed=3):
    rng = np.random.default_rng(seed)
    return problem.start + 0.3 * problem.structure.prior_widths * rng.standard_normal(len(problem.start))


def held(problem, values):
    """The structure and targets with the loads in force written into the rows."""
    targets = problem.blocks[0].targets
    torque = evaluate(problem.structure, values, targets).torque_n_mm
    stops = replace(
        targets.stops, torque_n_mm=np.zeros_like(targets.stops.joints_rad) if torque is None else torque
    )
    return replace(problem.structure, torques_measured=True), replace(targets, stops=stops)


def differences(structure, targets, values, k):
    """Central differences of positions and orientations in parameter k."""
    step = np.zeros(len(values))
    step[k] = 1e-4 * structure.specs[k].prior_width
    ahead, behind = (evaluate(structure, values + sign * step, targets) for sign in (1.0, -1.0))
    turned = ahead.orientation @ np.swapaxes(behind.orientation, 1, 2)
    return (
        (ahead.position_mm - behind.position_mm) / (2.0 * step[k]),
        vector_from_rotation(turned) / (2.0 * step[k]),
    )


def require_alike(structure, targets, values, owner, rel):
    state = evaluate(structure, values, targets)
    positions, rotations = position_jacobian(state), rotation_jacobian(state)
    own = [k for k, name in enumerate(structure.owners) if name == owner]
    for k in own:
        moved, turned = differences(structure, targets, values, k)
        name = structure.specs[k].name
        floor = ROUNDING_MM / structure.specs[k].prior_width
        largest = np.abs(moved).max()
        assert positions[k] == pytest.approx(moved, abs=rel * largest + floor), name
        # What turns without moving anything near it still moves a point a metre away.
        turning = max(np.abs(turned).max(), largest / 1000.0)
        assert rotations[k] == pytest.approx(turned, abs=rel * turning + floor / 1000.0), name
    return own


@pytest.mark.parametrize("cause", ON_POSITIONS)
def test_every_candidate_moves_positions_and_orientations_as_its_derivatives_say(cause):
    start = start_for(cause)
    problem = extended(telling_problem(start), cause, telling_scene(start))
    values = displaced(problem)
    structure, targets = held(problem, values)

    compared = require_alike(structure, targets, values, cause, EXACT)

    assert len(compared) > 0


@pytest.mark.parametrize("effect", [name for name in EFFECTS if name not in CAUSES])
def test_every_effect_that_is_no_cause_moves_positions_and_orientations_as_its_derivatives_say(effect):
    problem = telling_problem(tuple(dict.fromkeys(("base", effect))))
    values = displaced(problem)
    structure, targets = held(problem, values)

    require_alike(structure, targets, values, effect, EXACT)


@pytest.mark.parametrize(
    "cause", ["joint_coupling", "joint_gain", "backlash", "thermal_growth", "joint_harmonics"]
)
def test_joints_with_signs_and_links_of_any_kind_are_differentiated_alike(cause):
    joints = np.random.default_rng(7).uniform(-1.5, 1.5, (24, 7))
    campaign = telling_campaign(robot=SEVEN_AXES, joints_rad=joints)
    problem = extended(
        build(campaign, ("base", "geometry")), cause, telling_scene(("base", "geometry"), campaign)
    )
    values = displaced(problem)
    structure, targets = held(problem, values)

    assert require_alike(structure, targets, values, cause, EXACT)


@pytest.mark.parametrize("cause", ["payload", "link_mass"])
def test_a_wrong_mass_is_differentiated_through_the_slope_of_a_gear_that_is_softer_unloaded(cause):
    start = (*START, "compliance_nonlinear")
    problem = extended(telling_problem(start), cause, telling_scene(start))
    values = displaced(problem)
    structure, targets = held(problem, values)

    assert require_alike(structure, targets, values, cause, EXACT)


def test_products_of_springs_and_unknown_moments_are_differentiated_too():
    campaign = telling_campaign(robot=without_masses())
    start = ("base", "geometry")
    problem = extended(build(campaign, start), "compliance", telling_scene(start, campaign))
    values = problem.start + 0.1 * (displaced(problem) - problem.start)
    structure, targets = held(problem, values)

    assert require_alike(structure, targets, values, "compliance", EXACT)


@pytest.mark.parametrize(
    "cause", ["payload", "link_mass", "link_bending", "base_compliance", "compliance_nonlinear"]
)
def test_that_loads_follow_the_deflection_is_left_out_and_is_small(cause):
    problem = extended(telling_problem(), cause, telling_scene())
    values = displaced(problem)

    # A deflection changes the torque of its own joint by weight x lever x compliance: 7.7 kg * 9.81 m/s2 *
    # 6e-7 rad/(N mm) * 300 mm is 0.014 of it, and that of the next joints by as much again.
    assert require_alike(problem.structure, problem.blocks[0].targets, values, cause, rel=0.05)


def test_the_scene_of_these_tests_shows_every_cause_that_acts_on_positions():
    scenes = {name: telling_scene(start_for(name)) for name in ON_POSITIONS}

    blind = [name for name in ON_POSITIONS if not CAUSES[name].candidates(scenes[name])]

    assert blind == []
    assert IRB_120.masses  # else loads would not be among them
    assert scene_of(telling_problem()).torque_n_mm is not None
