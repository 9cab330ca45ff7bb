"""Plans before a camera: what it sees, what poses tell, and what accuracy that promises."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.exchange.cells.file import simulated_cell
from truepose.identification.problem.build import automatic_effects, build
from truepose.planning.prediction.robots_and_cells import of_cell
from truepose.planning.prediction.tracker import promised_session
from truepose.planning.tracker.plans import nominal_campaign, plan_calibration, scaled_jacobians
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import nominal_chain, space_to_measure

FEW = 80  # candidates: of half a million random configurations a flat artefact shows itself in one of sixty
FLAT, SPATIAL, TRACKER = "irb120-camera", "irb120-camera-spatial", "irb120-tilted"


def space(name):
    return space_to_measure(simulated_cell(name, 1), None)


def angles_to_the_camera_deg(here, joints_rad):
    chain = nominal_chain(here, joints_rad)
    nest = here.nests[here.camera.nest - 1]
    sight = np.array(here.camera.position_mm) - chain.points(np.array(nest.centre_mm))
    cosine = np.einsum("nij,j,ni->n", chain.end_rotation, nest.facing, sight)
    return np.degrees(np.arccos(cosine / np.linalg.norm(sight, axis=1)))


def test_a_flat_artefact_is_shown_to_the_camera_at_every_stop():
    plan = plan_calibration(space(FLAT), 20, seed=2, n_candidates=FEW)

    joints = np.array([stop.joints_rad for stop in plan.stops])

    assert {stop.nest for stop in plan.stops} == {4}
    assert angles_to_the_camera_deg(space(FLAT), joints).max() < 14.0


def test_a_spatial_artefact_is_seen_from_all_sides():
    drawn = draw_candidates(space(SPATIAL), FEW, np.random.default_rng(1))

    looks = nominal_chain(space(SPATIAL), drawn.joints_rad).end_rotation[:, 0, 2]  # of axis 6, along world x

    assert set(drawn.nest) == {4}
    assert looks.min() < -0.5 < 0.5 < looks.max()


def test_a_pose_tells_six_numbers_of_which_three_are_its_orientation():
    here = space(SPATIAL)
    at = draw_candidates(here, 8, np.random.default_rng(1))

    rows = scaled_jacobians(here, at)

    names = of_names(here, at)
    turned = [names.index(name) for name in ("tool_rx", "tool_ry", "tool_rz")]
    assert rows.shape[:2] == (8, 6)
    assert not rows[:, :3, turned].any()  # the artefact is turned about its centre
    # rotation vectors of the width of its certificate, in standard uncertainties of a reading
    size = here.camera.artefact_rotation_u_rad / here.camera.rotation_u_rad
    assert np.linalg.norm(rows[:, 3:, turned], axis=1) == pytest.approx(size, rel=1e-5)


def of_names(here, at):
    campaign = nominal_campaign(here, at)
    return build(campaign, automatic_effects(campaign)).structure.names


def test_a_tracker_tells_three_as_ever():
    here = space(TRACKER)

    assert scaled_jacobians(here, draw_candidates(here, 5, np.random.default_rng(1))).shape[1] == 3


@pytest.fixture(scope="module")
def promises():
    subjects = {name: of_cell(simulated_cell(name, 1)) for name in (FLAT, SPATIAL, TRACKER)}
    return {
        name: promised_session(one.space, 30, knowns=one.knowns, n_candidates=FEW)
        for name, one in subjects.items()
    }


def test_the_three_setups_of_the_thesis_are_promised_in_its_order(promises):
    tracker, spatial, flat = (promises[name].promised.mean_mm for name in (TRACKER, SPATIAL, FLAT))

    assert 2.0 * tracker < spatial < flat


def test_a_plan_says_what_no_pose_tells_of_the_artefact(promises):
    (left,) = promises[SPATIAL].left_open

    assert set(left.parameters) == {"theta_6", "tool_rz"}


def test_orientations_that_are_read_badly_promise_no_more_than_positions(promises):
    subject = of_cell(simulated_cell(SPATIAL, 1))
    blurred = replace(subject.space, camera=replace(subject.space.camera, rotation_u_rad=1.0))

    blind = promised_session(blurred, 30, knowns=subject.knowns, n_candidates=FEW)

    assert promises[SPATIAL].promised.mean_mm < blind.promised.mean_mm
