"""The three calibrations of the thesis (A. Nubiola, 2014, section 2.6) on one simulated arm.

Everything is asked of the simulated cell, whose physics goes another route than the models: where the nests
are when an instrument looks, and how long the bar is.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tests.studies.simulated_arms import read_back
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.campaign import Campaign, CupSetups, LegReadings, PointReadings, Stops
from truepose.domain.identification import Model
from truepose.identification import identify
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import Scenario, ToolSetup

BAR_MM: Final = 300.0
RANGE_MM: Final = 1.0
LENGTH_U_MM: Final = 0.0017  # of a reading with its zero and calibrator
_SCATTER_MM: Final = 0.0035  # of the arm, per axis
_AFTER_S: Final = 3600.0  # when the test is made; nothing drifts in these cells
# 45 mm off axis 6, 150 mm from the flange (2.2.2); masses as its text has them, not its Table 2.4.
_SPATIAL: Final = ToolSetup(
    nests_mm=((45.0, 0.0, 150.0), (-22.5, 38.971, 150.0), (-22.5, -38.971, 150.0)),
    facing=((1.0, 0.0, 0.5), (-0.5, 0.87, 0.5), (-0.5, -0.87, 0.5)),
    acceptance_deg=90.0,
    mass_kg=2.6,
    centre_of_gravity_mm=(-23.0, 0.0, 100.0),
)


@dataclass(frozen=True, slots=True)
class Calibration:
    """One of the three: which artefact, which instrument, how many configurations, which nests are tested."""

    name: str
    spatial: bool
    u_mm: float  # per axis
    configurations: int
    nests: tuple[int, int]
    printed: tuple[tuple[float, float, float], tuple[float, float, float]]  # mean, sd, largest of each nest


# Tables 2.12 and 2.13. A C-Track is good for some 0.070 mm in space, hence 0.040 mm per axis.
CALIBRATIONS: Final = (
    Calibration("tracker", False, 0.0156, 38, (1, 2), ((-0.105, 0.091, 0.327), (-0.148, 0.118, 0.437))),
    Calibration("C-Track", False, 0.040, 36, (1, 2), ((0.022, 0.110, 0.250), (-0.048, 0.135, 0.363))),
    Calibration("C-Track, spatial", True, 0.040, 35, (1, 3), ((0.091, 0.126, 0.328), (0.146, 0.130, 0.385))),
)


@dataclass(frozen=True, slots=True)
class CalibratedArm:
    """A simulated arm with one of its artefacts, and what a calibration found."""

    calibration: Calibration
    cell: Cell
    campaign: Campaign
    model: Model


def calibrated(scenario: str, seed: int, calibration: Calibration) -> CalibratedArm:
    """Measure all three nests in random configurations, and identify."""
    setup = _with_artefact(load_scenario(scenario).quiet(), calibration)
    wishes = RecordingRequest(calibration.configurations, 0, approach="from_below", attachments=1)
    recording = record(setup, seed, wishes)
    campaign = read_back(recording)
    if campaign.calibration is None:
        raise SystemExit("nothing was recorded")
    rng = np.random.default_rng((seed, calibration.configurations))
    points = _three_nests(recording.cell, campaign.calibration.stops, calibration.u_mm, rng)
    campaign = replace(campaign, calibration=points)
    model = identify(campaign).model
    if model is None:
        raise SystemExit("no model")
    return CalibratedArm(calibration, recording.cell, campaign, model)


def _with_artefact(scenario: Scenario, calibration: Calibration) -> Scenario:
    return replace(scenario, tool=_SPATIAL) if calibration.spatial else scenario


def _three_nests(cell: Cell, stops: Stops, u_mm: float, rng: np.random.Generator) -> PointReadings:
    n = len(stops)
    seen = _nests_mm(cell, stops.joints_rad, np.ones_like(stops.joints_rad), rng)
    rows = np.repeat(np.arange(n), 3)
    position = seen.reshape(-1, 3) + u_mm * rng.standard_normal((3 * n, 3))
    return PointReadings(stops.taken(rows), np.tile([1, 2, 3], n), position, np.full(3 * n, u_mm))


def _nests_mm(
    cell: Cell, joints_rad: np.ndarray, direction: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Return where the nests come to rest, shape (n, 3, 3)."""
    n = len(joints_rad)
    at = cell.conditions(joints_rad, direction, np.full(n, _AFTER_S), np.ones(n, dtype=np.int64))
    return np.asarray(cell.true_positions(at) + _SCATTER_MM * rng.standard_normal((n, 1, 3)))


def sphere_campaign(
    arm: CalibratedArm, plan: BallbarPlan, seed: int, *, one_sided: bool
) -> tuple[Campaign, int]:
    """Return the sphere test that the arm gives, and how many stops were out of the bar's range.

    Stops come from any side, as in the thesis, or from below.
    """
    rng = np.random.default_rng((seed, 11))
    (place,) = plan.placements
    held = np.array([place.setups[0].joints_rad])
    joints = np.array([pose.joints_rad for pose in place.poses])
    nest = np.array([pose.legs[0][1] for pose in place.poses])
    sides = np.ones_like(joints) if one_sided else rng.choice([-1.0, 1.0], joints.shape)
    ball = _nests_mm(arm.cell, held, np.ones_like(held), rng)[0, 0]
    places = _nests_mm(arm.cell, joints, sides, rng)[np.arange(len(nest)), nest - 1]
    length = np.linalg.norm(places - ball, axis=1) + LENGTH_U_MM * rng.standard_normal(len(nest))
    read = np.flatnonzero(np.abs(length - BAR_MM) <= RANGE_MM)
    stops = Stops(1 + read, joints[read], direction=sides[read].astype(np.int64))
    one = np.ones(len(read), dtype=np.int64)
    legs = LegReadings(stops, one, one, nest[read], length[read], np.full(len(read), LENGTH_U_MM))
    taught = CupSetups(one[:1], one[:1], held)
    tested = replace(
        arm.campaign,
        calibration=None,
        legs=legs,
        setup=taught,
        ballbar_nominal_mm=BAR_MM,
        ballbar_range_mm=RANGE_MM,
        setup_uncertainty_mm=_SCATTER_MM,
    )
    return tested, len(nest) - len(read)
