"""Tracker sessions: which configurations, in which order, and what accuracy they promise."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.planning.promise.curve import CurvePoint, Errors, curve, knee, sizes
from truepose.planning.promise.knowledge import ArmKnowledge, Knowns, Told
from truepose.planning.promise.order import most_informative_first
from truepose.planning.promise.plan import Assumptions, PromisedPlan, indices, require_some
from truepose.planning.promise.volume import VOLUME_CONFIGURATIONS, WorkVolume, sample
from truepose.planning.tracker.clear_ways import clear_order
from truepose.planning.tracker.session_plans import N_CANDIDATES, short_tour
from truepose.planning.work_volume.candidates import Candidates, draw_candidates
from truepose.planning.work_volume.work_space import WorkSpace

_STREAM: Final = 2  # of random numbers, apart from those of sessions


@dataclass(frozen=True, slots=True)
class Measured:
    """Readings that are there already; rows of one configuration may be several."""

    joints_rad: FloatArray  # (m, J)
    nest: IntArray  # (m,)
    configurations: int  # different ones


def promised_session(
    space: WorkSpace,
    n: int | None = None,
    *,
    knowns: Knowns | None = None,
    volume: WorkVolume | None = None,
    measured: Measured | None = None,
    seed: int = 0,
    n_candidates: int = N_CANDIDATES,
) -> PromisedPlan:
    """Choose configurations for a tracker session and say what accuracy they promise.

    Parameters
    ----------
    space : WorkSpace
    n : int, optional
        Configurations to measure; by default as many as the knee of the curve says, none where enough is
        measured.
    knowns : Knowns, optional
    volume : WorkVolume, optional
        Where accuracy counts; by default the joint ranges in which configurations are chosen.
    measured : Measured, optional
        What was measured before: the curve goes on from there.
    seed : int
    n_candidates : int
        Random candidates to choose from.

    Returns
    -------
    PromisedPlan

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for.
    WorkSpaceError, TooFewCandidatesError
        The cell does not offer that many configurations, or the volume holds no place of the arm.
    """
    require_some(n)
    rng = np.random.default_rng([seed, _STREAM])
    candidates = draw_candidates(space, max(n or 0, n_candidates), rng)
    knowledge = ArmKnowledge(space, candidates, knowns or Knowns())
    choice = _Choice(knowledge, candidates, measured or Measured(*_none(space), 0))
    before = choice.measured.configurations
    numbers = sizes(None if n is None else before + n, before + len(candidates), before)
    choice.add(numbers[-1] - before)
    points = curve(choice.errors(space, volume or WorkVolume(), rng), numbers)
    advised = knee(points)
    return choice.plan(space, points, advised, advised if n is None else before + n)


def _none(space: WorkSpace) -> tuple[FloatArray, IntArray]:
    return np.zeros((0, space.robot.n_joints)), np.zeros(0, dtype=np.int64)


def session_plan(plan: PromisedPlan) -> SessionPlan:
    """Return the session that measures a plan, each stop approached from below; no stop is visited twice."""
    nests = () if plan.nest is None else tuple(plan.nest.tolist())
    rows = enumerate(zip(plan.joints_rad.tolist(), nests, strict=True), start=plan.measured + 1)
    stops = tuple(PlannedStop(config, tuple(joints), nest) for config, (joints, nest) in rows)
    return SessionPlan("calibration", stops)


class _Choice:
    """Configurations in the order in which they were chosen, behind those that were measured."""

    def __init__(self, knowledge: ArmKnowledge, candidates: Candidates, measured: Measured) -> None:
        self.measured = measured
        self._knowledge = knowledge
        self._candidates = candidates
        self._chosen = candidates.subset(np.zeros(0, dtype=np.int64))
        self._told = knowledge.told(measured.joints_rad, measured.nest)

    def add(self, n: int) -> None:
        """Choose n candidates, the most informative first."""
        offered = self._knowledge.told(self._candidates.joints_rad, self._candidates.nest)
        before = self._told.rows.reshape(-1, offered.rows.shape[2])
        information = self._knowledge.prior() + before.T @ before
        order = most_informative_first(offered.rows, n, information)
        self._chosen = self._candidates.subset(order)
        self._told = Told(
            np.concatenate([self._told.rows, offered.rows[order]]),
            np.concatenate([self._told.held, offered.held[order]]),
        )

    def errors(self, space: WorkSpace, volume: WorkVolume, rng: np.random.Generator) -> Errors:
        """Return how errors over a volume follow from the number of configurations."""
        place = sample(space, volume, VOLUME_CONFIGURATIONS, rng)
        seen = self._knowledge.places(place.joints_rad, place.nest)

        def after(size: int) -> FloatArray:
            return self._knowledge.errors(self._first(size), seen)

        return Errors(after, self._knowledge.discrepancy, self._knowledge.repeatability_mm)

    def plan(
        self, space: WorkSpace, points: tuple[CurvePoint, ...], advised: int, total: int
    ) -> PromisedPlan:
        """Return the plan of the first `total`, in an order of short clear moves."""
        told = self._first(total)
        new = self._chosen.subset(np.arange(total - self.measured.configurations))
        visited = new.subset(_in_order(space, new.joints_rad))
        joints = np.concatenate([self.measured.joints_rad, new.joints_rad])
        reading = self._knowledge.reading_mm(joints, np.concatenate([self.measured.nest, new.nest]))
        return PromisedPlan(
            joints_rad=visited.joints_rad,
            nest=visited.nest,
            poses=None,
            curve=points,
            advised=advised,
            measured=self.measured.configurations,
            left_open=self._knowledge.left_open(told, joints),
            observability=indices(told.rows),
            assumptions=Assumptions(reading, self._knowledge.repeatability_mm, self._knowledge.discrepancy),
        )

    def _first(self, size: int) -> Told:
        """Return what so many configurations tell, the measured ones first."""
        rows = len(self.measured.nest) + size - self.measured.configurations
        return Told(self._told.rows[:rows], self._told.held[:rows])


def _in_order(space: WorkSpace, joints_rad: FloatArray) -> IntArray:
    """Return an order of short ways that keep off the table."""
    if not len(joints_rad):
        return np.zeros(0, dtype=np.int64)
    tour = short_tour(joints_rad)
    return np.asarray(tour[clear_order(space, joints_rad[tour])])
