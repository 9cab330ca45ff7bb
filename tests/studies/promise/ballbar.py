"""Ballbar campaigns of the simulated cell at the planned poses, held against what was promised."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tests.studies.promise.kept import Kept, kept
from tests.studies.promise.tracker import OTHER_PLACES, VOLUME, identified, predicted_mm, true_mm
from tests.studies.simulated_arms import read_back
from truepose.domain.arrays import FloatArray
from truepose.exchange.cells.file import simulated_cell
from truepose.identification.model.estimates import identified_anchors
from truepose.kinematics.frames import rigid_alignment
from truepose.planning.ballbar.plan import ballbar_cell
from truepose.planning.ballbar.poses import setups
from truepose.planning.prediction.ballbar import promised_ballbar_session, work_space_of
from truepose.planning.prediction.plan import BallbarPoses, PromisedPlan, WorkVolume, sample
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording.ballbars.campaign import (
    BallbarRecordingRequest,
    record_ballbar,
    write_ballbar_campaign,
)
from truepose_simulators.recording.ballbars.plan import plan_from
from truepose_simulators.recording.ballbars.readings import Cups
from truepose_simulators.scenarios.file import load_scenario

# Of the tracker beside the ballbar nothing is used here.
_NO_TRACKER = RecordingRequest(configurations=1, validation=0, attachments=1)


def ballbar_promises(scenario: str, seeds: Sequence[int], n: int | None = None) -> list[Kept]:
    """Plan once, the nominal robot being the same; record and identify every cell."""
    described = simulated_cell(scenario, 0)
    plan = promised_ballbar_session(described, n)
    places = sample(work_space_of(described), WorkVolume(), VOLUME, np.random.default_rng(OTHER_PLACES))
    made = plan_from(_document(scenario, plan), "the plan")
    wishes = BallbarRecordingRequest(aimed=True, approach="from_below", tracker=_NO_TRACKER)
    found = []
    for seed in seeds:
        recording = record_ballbar(load_scenario(scenario), seed, made, wishes)
        model = identified(read_back(recording, write_ballbar_campaign))
        cups = {(a.placement, a.base_point): np.array(a.centre_mm) for a in identified_anchors(model)}
        predicted = _in_true_frame(predicted_mm(model, places), cups, recording.cups)
        found.append(kept(plan, np.linalg.norm(predicted - true_mm(recording.cell, places), axis=1)))
    return found


def _in_true_frame(
    points_mm: FloatArray, cups_mm: dict[tuple[int, int], FloatArray], true: Cups
) -> FloatArray:
    """Return points of a model in the frame of the true cups."""
    keys = zip(true.placement.tolist(), true.base_point.tolist(), strict=True)
    rotation, translation = rigid_alignment(np.array([cups_mm[key] for key in keys]), true.true_mm)
    return np.asarray(points_mm @ rotation.T + translation)


def _document(scenario: str, plan: PromisedPlan) -> dict[str, Any]:
    """Return a plan as the recorder of campaigns reads it; joints in deg."""
    space = ballbar_cell(simulated_cell(scenario, 0))
    poses = plan.poses
    if poses is None:
        raise AssertionError("a plan of lengths has legs")
    return {
        "placements": [
            {
                "number": fixture.number,
                "cups_mm": fixture.cups_mm.tolist(),
                "setups": [
                    {"base_point": setup.base_point, "joints_deg": np.degrees(setup.joints_rad).tolist()}
                    for setup in setups(space, fixture)
                ],
                "poses": _poses(plan.joints_rad, poses, fixture.number),
            }
            for fixture in poses.fixtures
        ]
    }


def _poses(joints_rad: FloatArray, poses: BallbarPoses, placement: int) -> list[dict[str, Any]]:
    return [
        {"config": row + 1, "joints_deg": np.degrees(joints_rad[row]).tolist(), "legs": list(poses.legs[row])}
        for row in np.flatnonzero(poses.placement == placement).tolist()
    ]
