"""The plan of a ballbar session: where the base fixture goes, and which poses are measured there."""

from dataclasses import replace

import numpy as np

from service.analysis.tasks import BallbarPlanTask
from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan, PlannedPlacement, PlannedPose
from service.domain.cell import Cell
from service.domain.errors import ConfigurationError
from service.planning.ballbar.bodies import BallbarCell
from service.planning.ballbar.fixture import BaseFixture, base_fixture
from service.planning.ballbar.placements import Wish, suggest
from service.planning.ballbar.poses import reachable
from service.planning.ballbar.setups import setups


def plan_ballbar_session(task: BallbarPlanTask) -> BallbarPlan:
    """Return the plan that is asked for; raises ConfigurationError, TooFewCandidatesError."""
    cell, kit = task.setup.cell, task.setup.cell.ballbar or BallbarKit()
    arm = ballbar_cell(cell)
    if task.frames:
        numbered = enumerate(task.frames, 1)
        fixtures = tuple(base_fixture(number, frame, kit.base_points) for number, frame in numbered)
    else:
        wish = Wish(task.n_placements, kit.base_points, task.n_poses * task.n_placements, seed=task.seed)
        fixtures = suggest(arm, wish).fixtures
    placements: list[PlannedPlacement] = []
    for fixture in fixtures:
        first = 1 + sum(len(place.poses) for place in placements)
        placements.append(_placement(arm, fixture, task.n_poses, first))
    return BallbarPlan(tuple(placements))


def _placement(arm: BallbarCell, fixture: BaseFixture, n_poses: int, first: int) -> PlannedPlacement:
    every = reachable(arm, fixture, first)
    picked = np.unique(np.linspace(0, len(every) - 1, min(n_poses, len(every))).round().astype(int))
    poses: list[PlannedPose] = []
    for config, index in enumerate(picked, first):
        poses.append(replace(every[index], config=config))
    cups = tuple((float(x), float(y), float(z)) for x, y, z in fixture.cups_mm)
    return PlannedPlacement(fixture.number, fixture.frame, cups, setups(arm, fixture), tuple(poses))


def ballbar_cell(cell: Cell) -> BallbarCell:
    """Return what limits the arm in a cell; raises ConfigurationError."""
    ranges = cell.limits.joints or cell.robot.joint_limits or cell.robot.calibration_ranges
    centres = [nest.centre_mm for nest in cell.nests if nest.centre_mm is not None]
    if ranges is None:
        raise ConfigurationError(
            f"Neither the cell nor {cell.robot.name} says how far the joints go; give joints_deg under "
            "[limits]."
        )
    if len(centres) != 3:
        raise ConfigurationError("A ballbar pose needs three tool nests with known centres; enter them.")
    return BallbarCell(cell.robot, cell.base_nominal, np.array(centres), ranges)
