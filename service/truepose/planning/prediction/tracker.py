"""Tracker sessions: which configurations, in which order, and what accuracy they promise."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.cell import KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NotIdentifiable
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.planning.errors import NoWayError, TooFewCandidatesError
from truepose.planning.observability import most_informative_first
from truepose.planning.prediction.errors import CurvePoint, Errors, curve, knee, sizes
from truepose.planning.prediction.expected_covariance import ArmKnowledge, PriorKnowledge, ReadingInformation
from truepose.planning.prediction.plan import (
    VOLUME_CONFIGURATIONS,
    Assumptions,
    PromisedPlan,
    WorkVolume,
    because_of,
    indices,
    parameters_of,
    require_some,
    sample,
)
from truepose.planning.tracker.path_repair import clear_tour, pool_of, repair_order
from truepose.planning.tracker.plans import N_CANDIDATES, short_tour
from truepose.planning.tracker.pose_order import clear_order
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.capsules import look_at
from truepose.planning.workspace.space import WorkSpace, are_loaded_one_way

_STREAM: Final = 2  # of random numbers, apart from those of sessions
_NEAR: Final = 300  # configurations that may stand in for one that cannot be reached


@dataclass(frozen=True, slots=True)
class ExistingReadings:
    """Readings that are there already; rows of one configuration may be several.

    Attributes
    ----------
    joints_rad : ndarray, shape (m, J)
    nest : ndarray, shape (m,)
        1-based.
    configurations : int
        Different ones.
    """

    joints_rad: FloatArray
    nest: IntArray
    configurations: int


def promised_session(
    space: WorkSpace,
    n: int | None = None,
    *,
    knowns: PriorKnowledge | None = None,
    volume: WorkVolume | None = None,
    measured: ExistingReadings | None = None,
    seed: int = 0,
    n_candidates: int = N_CANDIDATES,
    one_sided: bool = False,
) -> PromisedPlan:
    """Choose configurations for a tracker session and say what accuracy they promise.

    Parameters
    ----------
    space : WorkSpace
    n : int, optional
        Configurations to measure; by default as many as the knee of the curve says, none where enough is
        measured.
    knowns : PriorKnowledge, optional
    volume : WorkVolume, optional
        Where accuracy counts; by default the joint ranges in which configurations are chosen.
    measured : ExistingReadings, optional
        What was measured before: the curve goes on from there.
    seed : int
        The same seed gives the same plan.
    n_candidates : int
        Random candidates to choose from.
    one_sided : bool
        Only configurations in which the gears that carry the arm are loaded from one side.

    Returns
    -------
    PromisedPlan

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for, or fixed nests lie on a line.
    WorkSpaceError, TooFewCandidatesError
        The cell does not offer that many configurations, or the volume holds no place of the arm.
    NoWayError
        No order was found on whose ways nothing touches.
    """
    require_some(n)
    rng = np.random.default_rng([seed, _STREAM])
    knowns, measured = knowns or PriorKnowledge(), measured or ExistingReadings(*_none(space), 0)
    drawn = _drawn(space, max(n or 0, n_candidates), rng, one_sided=one_sided)
    if not len(drawn):
        raise TooFewCandidatesError(
            f"None of the {n_candidates} measurable configurations leaves enough clearance for arm and tool. "
            f"Check the floor and the centres of the tool nests.{look_at(space.keep_outs)}"
        )
    choice = _Choice(space, drawn, knowns, measured)
    if n is not None and n > choice.offered:
        raise TooFewCandidatesError(
            f"{n} configurations were requested, but only {choice.offered} of {n_candidates} measurable ones "
            f"leave enough clearance for the arm. Request fewer.{look_at(space.keep_outs)}"
        )
    before = measured.configurations
    numbers = sizes(None if n is None else before + n, before + choice.offered, before)
    choice.add(numbers[-1] - before)
    errors = choice.errors(volume or WorkVolume(), rng)
    points = curve(errors, numbers)
    advised = knee(points)
    total = advised if n is None else before + n
    # Ways are looked for only once it is known how many are visited. What takes the place of another
    # tells less: the curve is computed again with what will be measured.
    if choice.exchanged_for_reach(total):
        points = curve(errors, numbers)

    def open_without(keep_outs: KeepOuts) -> frozenset[str]:
        # The same seed, so that what differs is what the volumes cost, not the draw.
        free, again = replace(space, keep_outs=keep_outs), np.random.default_rng([seed, _STREAM])
        other = _Choice(free, _drawn(free, n_candidates, again, one_sided=one_sided), knowns, measured)
        other.add(total - before)
        return parameters_of(other.left_open(total))

    left_open = because_of(space.keep_outs, choice.left_open(total), open_without)
    return choice.plan(points, advised, total, left_open)


def _drawn(space: WorkSpace, n: int, rng: np.random.Generator, *, one_sided: bool) -> Candidates:
    """Draw n candidates and keep those at which, and at whose approach, no bodies touch.

    Fewer than n are left; an empty set where no body fits anywhere.
    """
    drawn = draw_candidates(space, n, rng)
    # Drawn by the rules for points, which know neither elbow nor tool against arm.
    fit = pool_of(space, drawn.joints_rad).stand(np.arange(len(drawn)), 0.0)
    if one_sided:
        fit &= are_loaded_one_way(space, drawn.joints_rad)
    return drawn.subset(np.flatnonzero(fit))


def _none(space: WorkSpace) -> tuple[FloatArray, IntArray]:
    return np.zeros((0, space.robot.n_joints)), np.zeros(0, dtype=np.int64)


def session_plan(plan: PromisedPlan) -> SessionPlan:
    """Return the session that measures a plan, each stop approached from below; no stop is visited twice.

    Parameters
    ----------
    plan : PromisedPlan
        Of positions or of a closed loop.

    Returns
    -------
    SessionPlan
        Numbered on from the configurations that were measured before.

    Raises
    ------
    ConfigurationError
        The plan is of ballbar lengths.
    """
    if plan.nest is None:
        raise ConfigurationError("The plan is for ballbar lengths; a tracker session cannot measure them.")
    nests = plan.nest.tolist()
    rows = enumerate(zip(plan.joints_rad.tolist(), nests, strict=True), start=plan.measured + 1)
    stops = tuple(PlannedStop(config, tuple(joints), nest) for config, (joints, nest) in rows)
    return SessionPlan("calibration", stops)


class _Choice:
    """Configurations in the order in which they were chosen, behind those that were measured."""

    def __init__(
        self, space: WorkSpace, candidates: Candidates, knowns: PriorKnowledge, measured: ExistingReadings
    ) -> None:
        self._space, self._candidates, self._measured = space, candidates, measured
        self._knowledge = ArmKnowledge(space, candidates, knowns)
        self._offered = self._knowledge.told(candidates.joints_rad, candidates.nest)
        self._before = self._knowledge.told(measured.joints_rad, measured.nest)
        self._order = np.zeros(0, dtype=np.int64)  # rows of the candidates
        self._visited = self._order

    @property
    def offered(self) -> int:
        """Candidates that there are."""
        return len(self._candidates)

    def add(self, n: int) -> None:
        """Choose n candidates, the most informative first."""
        before = self._before.rows.reshape(-1, self._before.rows.shape[2])
        # What was measured counts as what is known: chosen is what tells most beside it.
        covariance = self._knowledge.covariance(before)
        self._order = most_informative_first(self._offered.rows, n, covariance)

    def errors(self, volume: WorkVolume, rng: np.random.Generator) -> Errors:
        """Return how errors over a volume follow from the number of configurations, those measured too."""
        place = sample(self._space, volume, VOLUME_CONFIGURATIONS, rng)
        seen = self._knowledge.places(place.joints_rad, place.nest)

        def after(size: int) -> FloatArray:
            return self._knowledge.errors(self._first(size), seen)

        return Errors(after, self._knowledge.discrepancy, self._knowledge.repeatability_mm)

    def exchanged_for_reach(self, total: int) -> bool:
        """Find the order of visits of the first `total`; others take the place of what cannot be reached.

        Returns whether some did. Raises NoWayError where nothing helps.
        """
        wanted = self._order[: total - self._measured.configurations]
        self._visited = _visits(self._space, self._candidates.joints_rad, wanted, self._order)
        if np.isin(self._visited, wanted).all():
            return False
        kept = wanted[np.isin(wanted, self._visited)]
        new = self._visited[~np.isin(self._visited, wanted)]
        # What cannot be reached goes last, so that the curve beyond this plan does not count on it.
        others = self._order[len(wanted) :]
        given_up = wanted[~np.isin(wanted, self._visited)]
        self._order = np.concatenate([kept, new, others[~np.isin(others, new)], given_up])
        return True

    def left_open(self, total: int) -> tuple[NotIdentifiable, ...]:
        """Return what the first `total` would leave open."""
        chosen = self._candidates.joints_rad[self._order[: total - self._measured.configurations]]
        joints = np.concatenate([self._measured.joints_rad, chosen])
        return self._knowledge.left_open(self._first(total), joints)

    def plan(
        self,
        points: tuple[CurvePoint, ...],
        advised: int,
        total: int,
        left_open: tuple[NotIdentifiable, ...],
    ) -> PromisedPlan:
        """Return the plan of the first `total`, in the order of their visits."""
        visited = self._candidates.subset(self._visited)
        joints = np.concatenate([self._measured.joints_rad, visited.joints_rad])
        reading = self._knowledge.reading_mm(joints, np.concatenate([self._measured.nest, visited.nest]))
        return PromisedPlan(
            joints_rad=visited.joints_rad,
            nest=visited.nest,
            poses=None,
            curve=points,
            advised=advised,
            measured=self._measured.configurations,
            left_open=left_open,
            observability=indices(self._first(total).rows, total),
            assumptions=Assumptions(
                reading,
                self._knowledge.repeatability_mm,
                self._knowledge.discrepancy,
                self._space.keep_outs.names,
            ),
        )

    def _first(self, size: int) -> ReadingInformation:
        """Return what so many configurations tell, the measured ones first."""
        order = self._order[: size - self._measured.configurations]
        return ReadingInformation(
            np.concatenate([self._before.rows, self._offered.rows[order]]),
            np.concatenate([self._before.held, self._offered.held[order]]),
        )


def _visits(space: WorkSpace, joints_rad: FloatArray, wanted: IntArray, order: IntArray) -> IntArray:
    """Return rows of configurations in an order of short ways on which nothing touches.

    What cannot be reached gives its place to the next most informative one, then to what is near.
    """
    if not len(wanted):
        return wanted
    pool, tour = pool_of(space, joints_rad), wanted[short_tour(joints_rad[wanted])]
    tour = tour[clear_order(space, joints_rad[tour])]

    def instead(present: Sequence[int], at: int) -> IntArray:
        away = np.abs(joints_rad - joints_rad[present[at]]).max(axis=1)
        ranked = np.concatenate([order, np.argsort(away, kind="stable")[:_NEAR]])
        # Each once, at the better of its two places.
        _, first = np.unique(ranked, return_index=True)
        ranked = ranked[np.sort(first)]
        return np.asarray(ranked[~np.isin(ranked, present)])

    tours = [tour, clear_tour(pool, tour)]
    if space.keep_outs:  # of which `clear_order` does not know
        tours.reverse()
    try:
        return repair_order(pool, tours[0], instead)
    except NoWayError:
        return repair_order(pool, tours[1], instead)
