"""Plans of ballbar sessions: what is wanted, whether cell and kit can do it, what a worker computes."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, cast

import numpy as np

from truepose.analysis.job_queue.supervisor import Perform, Turns
from truepose.analysis.job_queue.tasks import BallbarPlanTask, PrecalibrateTask
from truepose.domain.ballbar import (
    BallbarPlan,
    BallbarStep,
    Leg,
    PlannedPlacement,
    PreCalibration,
    SpherePlanRequest,
    StepKind,
)
from truepose.domain.cell import BallbarKit, Cell
from truepose.domain.errors import ConfigurationError
from truepose.domain.ledger import LedgerEntry
from truepose.domain.robot import FramePlacement
from truepose.messages.message import Message, Text, message
from truepose.planning.ballbar.bodies import BaseFixture, fixture_body
from truepose.planning.ballbar.length_forecast import forecast_lengths, unseen_swaps
from truepose.planning.workspace.bodies import CellBodies, bodies_of, rooms
from truepose.planning.workspace.path_clearance import Ways, path_warnings
from truepose.sessions.ballbar.cell import LookPastFixture, PreCalibrate
from truepose.sessions.ballbar.early_length_check import EarlyJudge
from truepose.sessions.ballbar.length_check import Judges
from truepose.sessions.ballbar.plan import steps
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.valid_readings import counting
from truepose.sessions.engine.ways import judged_ways, refuse_blocked
from truepose.sessions.errors import NoBallbarError
from truepose.storage.records import SessionSetup


@dataclass(frozen=True, slots=True)
class BallbarPlanRequest:
    """What is wanted of a ballbar session."""

    given: BallbarPlan | None = None  # None: poses, or placements too, are chosen
    frames: tuple[FramePlacement, ...] = ()  # of the base fixture; none: suggested
    placements: int = 1  # how many are suggested
    poses: int = 24  # of the whole session
    seed: int = 0
    sphere: SpherePlanRequest | None = None  # a sphere test at the one frame; None: six legs a pose

    def __post_init__(self) -> None:
        """Raise ConfigurationError where a sphere test has no place, or several."""
        if self.sphere is not None and len(self.frames) != 1:
            raise ConfigurationError(message("plan.refused.sphere_placements"))


def kit_of(setup: SessionSetup) -> BallbarKit:
    """Return the kit of a cell; raises NoBallbarError."""
    if setup.cell.ballbar is None:
        raise NoBallbarError(message("plan.refused.no_ballbar", cell=setup.cell.name))
    return setup.cell.ballbar


def path_warnings_of_plan(cell: Cell, plan: BallbarPlan, kit: BallbarKit) -> Text:
    """Return what to watch on the ways of a given plan that fits the robot.

    Looked at are arm and tool above the floor and off each other; what the base fixture looks like only its
    owner knows. Raises PlanRefusedError where a stop cannot be, or a way above a floor that is stated.
    """
    bodies, moves = bodies_of(cell), [step for step in steps(plan, kit) if step.target_rad is not None]
    # A stop before a way: what touches at its end touches on every way to it.
    refuse_blocked(_blocked_stop(bodies, moves))
    return judged_ways(bodies, _ways(moves))


def _blocked_stop(bodies: CellBodies, moves: Sequence[BallbarStep]) -> Message | None:
    found = rooms(bodies, np.array([step.target_rad for step in moves]))
    touching = np.flatnonzero(found.least_mm() < 0.0)
    if not touching.size:
        return None
    first = int(touching[0])
    return message("room.at.step", step=moves[first].id, touches=found.what_touches(first))


def _ways(moves: Sequence[BallbarStep]) -> Ways:
    """Return the motions from the first stop on; where the arm comes from before it nobody knows."""
    names, points = [], [moves[0].target_rad]
    for before, step in pairwise(moves):
        points += [*step.via_rad, step.target_rad]
        names += [message("room.way.steps", begin=before.id, end=step.id)] * (len(step.via_rad) + 1)
    joints = np.array(points)
    return Ways(tuple(names), joints[:-1], joints[1:])


def look_past_fixture_in(bodies: CellBodies) -> LookPastFixture:
    """Return who looks at ways among the bodies of a cell and a base fixture that stands there."""

    async def look(place: PlannedPlacement, cup: int | None, ways: Ways) -> Text:
        return await asyncio.to_thread(path_warnings, beside_fixture(bodies, place, cup), ways)

    return look


def beside_fixture(bodies: CellBodies, place: PlannedPlacement, cup: int | None) -> CellBodies:
    """Return the bodies of a cell in which the base fixture stands, without the cup that the tool goes to."""
    fixture = BaseFixture(place.number, place.frame, np.array(place.cups_mm))
    body = fixture_body(fixture, bodies.floor_z_mm)  # the posts of the cups come first
    return replace(bodies, fixture=body.some([k for k in range(len(body)) if k + 1 != cup]))


_WAITING: Final = 3  # of plans; each holds one of the sixteen places that the door has
_PATIENCE_S: Final = 300.0  # a plan takes a minute at most


class BallbarWork:
    """Sends tasks to a worker; what it says of its progress is nobody's here.

    One plan is made at a time. A pre-calibration waits for none: a person stands in the cell.
    """

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        # Plans took a core for a minute each, as many as were asked for (decision 0023).
        self._plans = Turns(at_once=1, waiting=_WAITING, patience_s=_PATIENCE_S)

    async def choose(self, setup: SessionSetup, wish: BallbarPlanRequest) -> BallbarPlan:
        """Return the plan of a session; cancelling it ends the worker. Raises TrueposeError, BusyError."""
        async with self._plans.taken():
            return cast(BallbarPlan, await self._perform(plan_task(setup, wish), _nobody))

    def precalibrator(self, setup: SessionSetup) -> PreCalibrate:
        """Return what says where to aim in a session from now on, and which lengths to expect there."""

        async def precalibrate(plan: BallbarPlan, entries: tuple[LedgerEntry, ...]) -> PreCalibration:
            task = PrecalibrateTask(setup, plan, counting(plan, kit_of(setup), entries))
            return cast(PreCalibration, await self._perform(task, _nobody))

        return precalibrate


def plan_task(setup: SessionSetup, wish: BallbarPlanRequest) -> BallbarPlanTask:
    """Return the choice of poses and placements as a worker is asked for it."""
    return BallbarPlanTask(setup, wish.frames, wish.placements, wish.poses, wish.seed, wish.sphere)


async def _nobody(fraction: float, doing: Text) -> None:
    """Take progress that nobody follows."""


class Sight:
    """The judges of one session, and the swaps that they do not see."""

    def __init__(self, setup: SessionSetup, plan: BallbarPlan, kit: BallbarKit) -> None:
        known = forecast_lengths(setup.cell, plan, kit)
        self._early = None if known is None else EarlyJudge(known, kit)
        self._unseen = () if known is None else unseen_swaps(known, plan, kit)

    @property
    def judges(self) -> Judges:
        """Who judges the lengths of the session."""
        return Judges(early=self._early)

    def alike(self, now: Situation) -> tuple[tuple[Leg, Leg], ...]:
        """Return the pairs of legs of the present pose whose exchange would not show."""
        return () if self._early is None else self._early.alike(now)

    def sees_swaps(self, now: Situation) -> bool:
        """Whether an exchange of any two legs of the present pose shows, but for chance."""
        if self._early is None or now.step is None or now.step.kind is not StepKind.CONNECT_LEG:
            return now.forecast is not None
        return not self._early.alike(now)

    def unseen(self, now: Situation) -> tuple[int, ...]:
        """Return the poses ahead of which an exchange is hardly seen when it is made."""
        # With a pre-calibration lengths are foreseen, and an exchange is found by it.
        if any(now.outcomes[step.id].kind == "computed" for step in now.steps):
            return ()
        ahead = {
            step.config
            for step in now.steps
            if step.kind is StepKind.CONNECT_LEG and now.outcomes[step.id].kind == "open"
        }
        return tuple(config for config in self._unseen if config in ahead)
