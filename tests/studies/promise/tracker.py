"""Tracker campaigns of the simulated cell at the planned configurations, held against what was promised."""

from dataclasses import replace
from typing import Final

import numpy as np

from tests.studies.promise.kept import Kept, kept
from tests.studies.simulated_arms import of_nest, read_back, true_nests_mm
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, Stops
from truepose.domain.identification import Model
from truepose.exchange.cells.file import simulated_cell
from truepose.identification import identify, predict
from truepose.planning.prediction.expected_covariance import PriorKnowledge
from truepose.planning.prediction.plan import PromisedPlan, VolumeSample, WorkVolume, sample
from truepose.planning.prediction.robots_and_cells import of_campaign
from truepose.planning.prediction.tracker import promised_session
from truepose.planning.workspace.space import space_to_measure
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording import Stops as RecordedStops
from truepose_simulators.recording.campaign import record_at
from truepose_simulators.scenarios.file import load_scenario

_APPROACH_RAD: Final = -0.0872664626  # -5 deg on all joints, thesis of A. Nubiola, 2014, section 2.4
_STOP_S: Final = 28.0
VOLUME: Final = 300  # configurations over which the true error is averaged
OTHER_PLACES: Final = 77  # a stream of its own: not the places that the promise was computed at


def tracker_promise(scenario: str, seed: int, n: int | None = None) -> Kept:
    """Plan, record and identify one simulated cell."""
    described = simulated_cell(scenario, seed)
    space = space_to_measure(described, _APPROACH_RAD)
    plan = promised_session(space, n, knowns=PriorKnowledge(fixed_nests=described.fixed_nests), seed=seed)
    cell = Cell(load_scenario(scenario), seed, CellClock(0))
    model = identified(recorded(cell, plan))
    places = sample(space, WorkVolume(), VOLUME, np.random.default_rng([seed, OTHER_PLACES]))
    return kept(plan, np.linalg.norm(predicted_mm(model, places) - true_mm(cell, places), axis=1))


def resumed_promise(scenario: str, seed: int, before: int = 50, new: int = 20) -> Kept:
    """Measure, plan more from what that showed, measure both together; drift and warm-up are left out.

    What no parameter expresses is then known from the robot's own campaign only.
    """
    described = simulated_cell(scenario, seed)
    space = space_to_measure(described, _APPROACH_RAD)
    cell = Cell(load_scenario(scenario).quiet(), seed, CellClock(0))
    first = promised_session(
        space, before, knowns=PriorKnowledge(fixed_nests=described.fixed_nests), seed=seed
    )
    campaign = recorded(cell, first)
    known = of_campaign(campaign, identified(campaign))
    plan = promised_session(known.space, new, knowns=known.knowns, measured=known.measured, seed=seed)
    together = replace(
        plan,
        joints_rad=np.concatenate([first.joints_rad, plan.joints_rad]),
        nest=np.concatenate([_nests(first), _nests(plan)]),
    )
    model = identified(recorded(cell, together))
    places = sample(space, WorkVolume(), VOLUME, np.random.default_rng([seed, OTHER_PLACES]))
    return kept(plan, np.linalg.norm(predicted_mm(model, places) - true_mm(cell, places), axis=1))


def _nests(plan: PromisedPlan) -> IntArray:
    if plan.nest is None:
        raise AssertionError("a plan of positions has nests")
    return plan.nest


def recorded(cell: Cell, plan: PromisedPlan) -> Campaign:
    """Return the campaign of a cell at the configurations of a plan, read back from its files."""
    return recorded_stops(cell, plan.joints_rad, _nests(plan))


def recorded_stops(cell: Cell, joints_rad: FloatArray, nest: IntArray) -> Campaign:
    """Return the campaign of a cell at configurations (n, J), each approached from below."""
    n = len(joints_rad)
    joints = np.round(np.degrees(joints_rad), 5)
    stops = RecordedStops(
        joints_deg=joints,
        direction=np.ones_like(joints),
        time_s=_STOP_S * np.arange(1.0, n + 1.0),
        attachment=np.ones(n),
        nest=nest,
        repeat_of=np.zeros(n, dtype=int),
    )
    recording, _ = record_at(cell, stops, RecordingRequest(configurations=n, validation=0, attachments=1))
    return read_back(recording)


def identified(campaign: Campaign) -> Model:
    """Return the model of a campaign, which a study takes for granted."""
    model = identify(campaign).model
    if model is None:
        raise AssertionError(f"nothing could be identified of {campaign.robot.name}")
    return model


def predicted_mm(model: Model, places: VolumeSample) -> FloatArray:
    """Return where a model has the nests, shape (m, 3)."""
    stops = Stops(
        np.arange(1, len(places) + 1),
        places.joints_rad,
        direction=np.ones(places.joints_rad.shape, dtype=np.int64),
    )
    return predict(model, stops, places.nest)[0]


def true_mm(cell: Cell, places: VolumeSample) -> FloatArray:
    """Return where the nests truly are, scatter of the arm not included, shape (m, 3)."""
    return of_nest(true_nests_mm(cell, places.joints_rad, _STOP_S), places.nest)
