"""One simulated arm, measured in every way that there is: what each session would have brought home."""

from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Final

from tests.studies.ballbar_report.plans import plan_document
from tests.studies.camera.setups import FLAT, TRACKER, measured, planned, setup
from tests.studies.loops.held_out import Truth
from tests.studies.loops.recorded import truth_of
from tests.studies.simulated_arms import read_back
from truepose.domain.campaign import Campaign
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.ballbar.plan import ballbar_plan
from truepose_simulators.recording import RecordingRequest, record
from truepose_simulators.recording.ballbars.campaign import (
    BallbarRecordingRequest,
    record_ballbar,
    write_ballbar_campaign,
)
from truepose_simulators.recording.ballbars.plan import BallbarPlan, plan_from
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop, write_loop
from truepose_simulators.scenarios.file import load_scenario

_POSES: Final = 36  # of tracker and camera, as in the thesis
_BALLBAR_POSES: Final = 30
_STOPS: Final = 100  # of a loop: a reading there is one length
_JUDGED: Final = 300
JUDGED_NEST: Final = 2  # which every way knows in the tool

Measure = Callable[[int], Campaign]


def _by_instrument(scenario: str) -> Measure:
    def measure(seed: int) -> Campaign:
        here = setup(scenario, seed)
        return measured(here, planned(here, _POSES))

    return measure


def _by_loop(kind: str) -> Measure:
    def measure(seed: int) -> Campaign:
        wishes = LoopRecordingRequest(kind, _STOPS)
        return read_back(record_loop(load_scenario(TRACKER), seed, wishes), write_loop)

    return measure


def _by_ballbar(seed: int) -> Campaign:
    wishes = BallbarRecordingRequest(aimed=True)
    recording = record_ballbar(load_scenario(TRACKER), seed, _plan_of_ballbar(), wishes)
    return read_back(recording, write_ballbar_campaign)


@cache
def _plan_of_ballbar() -> BallbarPlan:
    """Return the plan of all arms: it knows the nominal one only."""
    plan = ballbar_plan(simulated_cell(TRACKER, 0), poses=_BALLBAR_POSES)
    return plan_from(plan_document(plan), "the plan")


WAYS: Final[Mapping[str, Measure]] = MappingProxyType({
    f"tracker, {_POSES} configurations": _by_instrument(TRACKER),
    f"camera, {_POSES} poses of the flat artefact": _by_instrument(FLAT),
    f"ballbar, {_BALLBAR_POSES} poses of six legs": _by_ballbar,
    f"two spheres and a probe, {_STOPS} stops": _by_loop("two-spheres"),
    f"three wires, {_STOPS} stops": _by_loop("wires"),
})


def judged_at(seed: int) -> Truth:
    """Return where the tool of an arm truly was, all over the work volume; the same for every way."""
    wishes = RecordingRequest(configurations=1, validation=_JUDGED, attachments=1, reference_every=0)
    recording = record(load_scenario(TRACKER), seed, wishes)
    return truth_of(recording.cell, recording.validation.stops)
