"""The three setups of the thesis (A. Nubiola, 2014, chapter 2) on one simulated arm: measured, identified.

Everything is asked of the simulated cell, whose physics goes another route than the models. A session chooses
the configurations; what it reads is drawn here as the simulated instruments draw it, without the wires.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from tests.studies.simulated_arms import true_nests_mm
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.cell import Camera
from truepose.domain.cell import Cell as CellFile
from truepose.exchange.cells.file import simulated_cell
from truepose.kinematics.frames import quaternion_from_rotation
from truepose.planning.tracker.plans import plan_calibration
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.space import WorkSpace, space_to_measure
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.camera import Camera as SimulatedCamera
from truepose_simulators.physics.rigid import register
from truepose_simulators.scenarios.file import load_scenario

TRACKER, FLAT, SPATIAL = "irb120-tilted", "irb120-camera", "irb120-camera-spatial"
APPROACH_RAD: Final = -0.0872664626  # -5 deg on all joints, thesis section 2.4
_FRAMES: Final = 60  # of a second
RIGID: Final = np.sqrt(6.0 / 9.0)  # of the errors of three nests, that a rigid body keeps


@dataclass(frozen=True, slots=True)
class Setup:
    """A simulated cell, and how its owner describes it."""

    cell: Cell
    file: CellFile
    space: WorkSpace
    seed: int

    @property
    def camera(self) -> Camera | None:
        """The camera; None of the tracker's setup."""
        return self.file.camera


def setup(scenario: str, seed: int) -> Setup:
    """Build one of the three."""
    file = simulated_cell(scenario, seed)
    cell = Cell(load_scenario(scenario), seed, CellClock(0))
    return Setup(cell, file, space_to_measure(file, APPROACH_RAD), seed)


def planned(here: Setup, n: int) -> Candidates:
    """Return n configurations as a session chooses them, revisits left out."""
    stops = plan_calibration(here.space, n, here.seed).stops[:n]
    return Candidates(np.array([s.joints_rad for s in stops]), np.array([s.nest for s in stops]))


def drawn(here: Setup, n: int) -> Candidates:
    """Return n random configurations that the instrument sees."""
    return draw_candidates(here.space, n, np.random.default_rng((here.seed, 1)))


def anywhere(here: Setup, n: int) -> FloatArray:
    """Return random configurations (n, J) of the whole work space, seen or not."""
    unseen = replace(here.space, tracker_position_mm=None, camera=None, nests=_unfacing(here))
    return draw_candidates(unseen, n, np.random.default_rng((here.seed, 2))).joints_rad


def _unfacing(here: Setup) -> tuple:
    return tuple(replace(nest, facing=None) for nest in here.space.nests)


def measured(here: Setup, at: Candidates) -> Campaign:
    """Return the campaign of one reading at each configuration."""
    rng = np.random.default_rng((here.seed, 3))
    true_mm = true_nests_mm(here.cell, at.joints_rad)
    true_mm = true_mm + here.cell.scenario.arm.scatter_mm * rng.normal(size=(len(at), 1, 3))
    readings: Callable = _points if here.camera is None else _poses
    return Campaign(
        robot=here.file.robot,
        base_nominal=here.file.base_nominal,
        nests=here.file.nests,
        calibration=readings(here, at, true_mm, rng),
        tracker_position_mm=here.file.tracker_position_mm,
        tool_rotation_uncertainty_rad=None if here.camera is None else here.camera.artefact_rotation_u_rad,
    )


def _points(here: Setup, at: Candidates, true_mm: FloatArray, rng: np.random.Generator) -> PointReadings:
    tracker = here.cell.scenario.tracker
    place = true_mm[np.arange(len(at)), at.nest - 1]
    beam = place - np.array(tracker.position_mm)
    metres = np.linalg.norm(beam, axis=1, keepdims=True) / 1000.0
    along = beam / np.linalg.norm(beam, axis=1, keepdims=True)
    noise = (tracker.across_mm + tracker.across_mm_per_m * metres) * rng.normal(size=place.shape)
    noise -= along * np.sum(along * noise, axis=1, keepdims=True)
    noise += along * (tracker.along_mm + tracker.along_mm_per_m * metres) * rng.normal(size=(len(at), 1))
    stops = Stops(np.arange(1, len(at) + 1), at.joints_rad)
    return PointReadings(stops, at.nest, place + noise, np.full(len(at), 0.0156))


def _poses(here: Setup, at: Candidates, true_mm: FloatArray, rng: np.random.Generator) -> PointReadings:
    camera, known = SimulatedCamera(here.cell, here.cell.scenario.camera), here.camera
    sigma = np.hypot(camera.setup.nest_mm, camera.setup.frame_mm / np.sqrt(_FRAMES)) / RIGID
    seen_mm = true_mm + sigma * rng.normal(size=true_mm.shape)
    poses = np.array([register(camera.defined_mm, nests) for nests in seen_mm])
    turn, shift = poses[:, :3, :3], poses[:, :3, 3]
    n, centre = len(at), np.array(here.file.nests[known.nest - 1].centre_mm)
    return PointReadings(
        Stops(np.arange(1, n + 1), at.joints_rad),
        np.full(n, known.nest),
        turn @ centre + shift,
        np.full(n, known.position_u_mm),
        quaternion=quaternion_from_rotation(turn),
        rotation_uncertainty_rad=np.full(n, known.rotation_u_rad),
    )


def positions_only(campaign: Campaign) -> Campaign:
    """Return a campaign of poses as if orientations were not told."""
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)
    return replace(campaign, calibration=alone)
