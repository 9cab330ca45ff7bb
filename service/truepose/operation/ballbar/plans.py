"""Plans of ballbar sessions: what is wanted of one, and whether this cell and this kit can do it."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.cell.description import Cell
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.ballbar import BallbarPlan, BallbarStep, SphereWish
from truepose.domain.robot import FramePlacement
from truepose.operation.errors import NoBallbarError
from truepose.planning.work_volume.cell_bodies import CellBodies, bodies_of, rooms
from truepose.planning.work_volume.room_on_ways import Ways, what_blocks_a_way, what_to_watch
from truepose.sequencing.ballbar.plan.agenda import steps
from truepose.sequencing.errors import PlanRefusedError
from truepose.storage.records import SessionSetup


@dataclass(frozen=True, slots=True)
class BallbarWish:
    """What is wanted of a ballbar session."""

    given: BallbarPlan | None = None  # None: poses, or placements too, are chosen
    frames: tuple[FramePlacement, ...] = ()  # of the base fixture; none: suggested
    placements: int = 1  # how many are suggested
    poses: int = 24  # of the whole session
    seed: int = 0
    sphere: SphereWish | None = None  # a sphere test at the one frame; None: six legs a pose

    def __post_init__(self) -> None:
        """Raise ConfigurationError where a sphere test has no place, or several."""
        if self.sphere is not None and len(self.frames) != 1:
            raise ConfigurationError(
                "A sphere test has one ball, in cup 1 of the base fixture: give one placement of the fixture."
            )


def kit_of(setup: SessionSetup) -> BallbarKit:
    """Return the kit of a cell; raises NoBallbarError."""
    if setup.cell.ballbar is None:
        raise NoBallbarError(
            f"The cell file of {setup.cell.name} describes no ballbar; give it a [ballbar] section."
        )
    return setup.cell.ballbar


def judged(cell: Cell, plan: BallbarPlan, kit: BallbarKit) -> str:
    """Return what to watch on the ways of a given plan that fits the robot.

    Looked at are arm and tool above the floor and off each other; what the base fixture looks like only its
    owner knows. Raises PlanRefusedError where a stop cannot be, or a way above a floor that is stated.
    """
    bodies, moves = bodies_of(cell), [step for step in steps(plan, kit) if step.target_rad is not None]
    ways = _ways(moves)
    blocked = _blocked_stop(bodies, moves) or what_blocks_a_way(bodies, ways)
    if blocked is not None:
        raise PlanRefusedError(blocked)
    return what_to_watch(bodies, ways)


def _blocked_stop(bodies: CellBodies, moves: Sequence[BallbarStep]) -> str | None:
    found = rooms(bodies, np.array([step.target_rad for step in moves]))
    touching = np.flatnonzero(found.least_mm() < 0.0)
    if not touching.size:
        return None
    first = int(touching[0])
    return f"The stop of step {moves[first].id} cannot be: {found.what_touches(first)}."


def _ways(moves: Sequence[BallbarStep]) -> Ways:
    """Return the motions from the first stop on; where the arm comes from before it nobody knows."""
    names, points = [], [moves[0].target_rad]
    for before, step in pairwise(moves):
        points += [*step.via_rad, step.target_rad]
        names += [f"from step {before.id} to step {step.id}"] * (len(step.via_rad) + 1)
    joints = np.array(points)
    return Ways(tuple(names), joints[:-1], joints[1:])
