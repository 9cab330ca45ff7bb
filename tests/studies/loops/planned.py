"""Closed loops at planned stops: whether what a plan promises is what the simulated cell attains."""

from typing import Final

import numpy as np

from tests.studies.loops.held_out import HeldOut, held_out
from tests.studies.loops.recorded import truth_of
from tests.studies.simulated_arms import read_back
from truepose.domain.campaign import TargetDistances
from truepose.domain.contacts import Target, TargetKind
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.contacts.loop_configurations import LoopPlanRequest
from truepose.planning.contacts.loop_prediction import promised_loop
from truepose.planning.prediction.plan import PromisedPlan
from truepose.planning.workspace.space import space_to_measure
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop, write_loop
from truepose_simulators.recording.closed_loops import LOOPS, Loop, LoopConfigurations
from truepose_simulators.scenarios.file import load_scenario

_APPROACH_RAD: Final = -0.0872664626


def planned(scenario: str, kind: str, n: int | None) -> PromisedPlan:
    """Plan a loop of the simulators where its drawing has it."""
    space = space_to_measure(simulated_cell(scenario, 1), _APPROACH_RAD)
    return promised_loop(space, _wish(LOOPS[kind]), n)


def _wish(loop: Loop) -> LoopPlanRequest:
    targets = tuple(
        Target(
            number,
            TargetKind(placed.kind),
            placed.zero_mm,
            loop.u_zero_mm if placed.zero_mm is not None else 0.0,
            loop.form_mm,
            placed.place_mm,
            placed.normal,
        )
        for number, placed in enumerate(loop.placed, start=1)
    )
    return LoopPlanRequest(targets, loop.nests, loop.u_mm, _distance(loop))


def _distance(loop: Loop) -> TargetDistances | None:
    if loop.u_distance_mm is None:
        return None
    first, second = (np.array(placed.place_mm) for placed in loop.placed[:2])
    length = np.array([np.linalg.norm(second - first)])
    return TargetDistances(np.array([1]), np.array([2]), length, np.array([loop.u_distance_mm]))


def attained(scenario: str, seed: int, kind: str, plan: PromisedPlan) -> HeldOut:
    """Record the planned stops, calibrate, and hold the model against the truth."""
    if plan.nest is None or plan.targets is None:
        raise SystemExit("this is no plan of a closed loop")
    first = np.array([numbers[0] - 1 for numbers in plan.targets])
    stands = LoopConfigurations(np.degrees(plan.joints_rad).round(5), plan.nest, first)
    recording = record_loop(load_scenario(scenario), seed, LoopRecordingRequest(kind, validation=10), stands)
    return held_out(read_back(recording, write_loop), truth_of(recording.cell, recording.points.stops))
