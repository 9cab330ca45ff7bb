r"""A closed loop planned with what it promises, before anything is measured.

As for positions (`planning.prediction.knowledge`): in the widths of the priors the parameters, those of the
targets and of certified nests among them, have the information

    M = I + sum over certified distances + sum over stops of J~' J~

and errors of predicted places are G M^-1/2 z. Where the base stands nobody sees, so that the rigid motion
which brings a draw of errors closest to none is taken out of it.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import NotIdentifiable
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification.model.derivatives import place_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import Problem, automatic_effects, build
from truepose.identification.verdict.identifiability import undetermined_by_configurations
from truepose.planning.contacts.loop_configurations import (
    LoopPlanRequest,
    LoopStops,
    draw_stands,
    nominal_loop,
)
from truepose.planning.observability import most_informative_first
from truepose.planning.prediction.errors import NONE, Discrepancy, Errors, curve, knee, sizes
from truepose.planning.prediction.expected_covariance import covariance_root
from truepose.planning.prediction.plan import (
    Assumptions,
    PromisedPlan,
    WorkVolume,
    indices,
    require_some,
    sample,
)
from truepose.planning.tracker.plans import short_tour
from truepose.planning.workspace.space import WorkSpace, require_consistent

_CANDIDATES: Final = 600
_VOLUME: Final = 200  # configurations
_STREAM: Final = 41  # of random numbers
_CERTIFIED: Final = effects_with(Trait.NUISANCE)  # nobody asks how well these are seen
_MOVED_RAD: Final = np.deg2rad(0.5)


def promised_loop(
    space: WorkSpace,
    wish: LoopPlanRequest,
    n: int | None = None,
    *,
    discrepancy: Discrepancy = NONE,
    volume: WorkVolume | None = None,
    seed: int = 0,
) -> PromisedPlan:
    """Choose stops of a closed loop, and say what accuracy they promise.

    Parameters
    ----------
    space : WorkSpace
        Arm, tool and what is around them.
    wish : LoopPlanRequest
        Targets, nests and instrument.
    n : int, optional
        How many stops; by default the knee of the curve.
    discrepancy : Discrepancy
        What no parameter expresses.
    volume : WorkVolume, optional
        Where accuracy counts; by default the joint ranges in which stops are chosen.
    seed : int
        The same seed gives the same plan.

    Returns
    -------
    PromisedPlan
        Stops of each group of targets one after another; `targets` says what is read at each.

    Raises
    ------
    ConfigurationError
        Fewer than one stop was asked for, or no nest that the tool has.
    WorkSpaceError, TooFewCandidatesError
        The tool has no nest, or what is said of the cell contradicts itself otherwise; the arm does not reach
        a target, or has no place in the volume.
    """
    require_some(n)
    require_consistent(space)
    rng = np.random.default_rng([seed, _STREAM])
    stands = draw_stands(space, wish, max(n or 0, _CANDIDATES), rng)
    knowledge = _Knowledge(space, wish, stands, discrepancy)
    numbers, nothing = sizes(n, len(stands.nest)), np.zeros(0, dtype=np.int64)
    order = most_informative_first(knowledge.rows, numbers[-1], knowledge.covariance(nothing))
    places = sample(space, volume or WorkVolume(), _VOLUME, rng)
    motion = knowledge.motion(places.joints_rad, places.nest)
    errors = Errors(
        lambda size: motion @ knowledge.root(order[:size]), discrepancy, knowledge.repeatability_mm
    )
    points = curve(errors, numbers)
    advised = knee(points)
    chosen = _visits(stands, order[: advised if n is None else n])
    numbers_of = [tuple(target.number for target in group) for group in wish.groups]
    return PromisedPlan(
        joints_rad=stands.joints_rad[chosen],
        nest=stands.nest[chosen],
        poses=None,
        curve=points,
        advised=advised,
        measured=0,
        left_open=knowledge.left_open(chosen),
        # Certificates' own parameters are hardly seen by design: they would make every index next to
        # nothing.
        observability=indices(knowledge.rows[chosen][:, :, knowledge.asked], len(chosen)),
        assumptions=Assumptions(
            wish.reading_mm, knowledge.repeatability_mm, discrepancy, space.keep_outs.names
        ),
        targets=tuple(numbers_of[group] for group in stands.group[chosen].tolist()),
    )


def _visits(stands: LoopStops, chosen: IntArray) -> IntArray:
    """Return the stops group by group, each in an order of short ways."""
    groups = stands.group[chosen]
    parts = [chosen[groups == group] for group in np.unique(groups).tolist()]
    return np.concatenate([part[short_tour(stands.joints_rad[part])] for part in parts])


class _Knowledge:
    """The parameters of arm and targets, and what readings at each of n stops tell."""

    def __init__(
        self, space: WorkSpace, wish: LoopPlanRequest, stands: LoopStops, discrepancy: Discrepancy
    ) -> None:
        campaign, stop = nominal_loop(space, wish, stands)
        self._problem: Problem = build(campaign, automatic_effects(campaign))
        self._structure, self._start = self._problem.structure, self._problem.start
        self._widths = self._structure.prior_widths
        contacts, *certified = self._problem.blocks
        # What no parameter expresses counts at contacts only: certified distances have no arm in
        # them.
        block = contacts.weighted(contacts.weights, discrepancy.per_axis_mm)
        white = block.result(self._structure, self._start, None).white_jacobian.T * self._widths
        self._joints = stands.joints_rad
        self.rows = _by_stop(white, stop, len(stands.nest))
        self.asked = np.array([owner not in _CERTIFIED for owner in self._structure.owners])
        # Certified distances are known before any stop, as priors are.
        self._before = [np.eye(len(self._widths))]
        for other in certified:
            told = other.result(self._structure, self._start, None).white_jacobian.T * self._widths
            self._before.append(told)

    @property
    def repeatability_mm(self) -> float:
        """Scatter of the arm per axis."""
        return self._structure.robot.repeatability_mm

    def motion(self, joints_rad: FloatArray, nest: IntArray) -> FloatArray:
        """Return the motion of places per width of each parameter, rigid ones taken out, shape (m, 3, P).

        With U an orthonormal basis of the six rigid motions of the m places (QR), G - U U' G: the
        least-squares fit of a rigid motion to each column is taken off it [mm].
        """
        stops = Stops(np.arange(len(nest)), joints_rad)
        state = evaluate(self._structure, self._start, Targets(stops, nest))
        motion = np.moveaxis(place_jacobian(state), 0, -1) * self._widths
        flat = motion.reshape(-1, motion.shape[2])
        rigid = np.linalg.qr(_rigid_motions(state.position_mm))[0]
        return np.asarray((flat - rigid @ (rigid.T @ flat)).reshape(motion.shape))

    def root(self, stops: IntArray) -> FloatArray:
        """Return a root of the covariance of the parameters after some stops, shape (P, P)."""
        rows = self.rows[stops].reshape(-1, self.rows.shape[2])
        return covariance_root(np.concatenate([*self._before, rows]))[0]

    def covariance(self, stops: IntArray) -> FloatArray:
        """Return the covariance of the parameters after some stops, shape (P, P)."""
        root = self.root(stops)
        return np.asarray(root @ root.T)

    def left_open(self, stops: IntArray) -> tuple[NotIdentifiable, ...]:
        """Return what readings at some stops leave open."""
        rows = self.rows[stops].reshape(-1, self.rows.shape[2])
        covariance = self.covariance(stops) * np.outer(self._widths, self._widths)
        moved = np.ptp(self._joints[stops], axis=0) > _MOVED_RAD
        return undetermined_by_configurations(
            self._structure, covariance, rows.T / self._widths[:, None], moved
        )


def _by_stop(white: FloatArray, stop: IntArray, n: int) -> FloatArray:
    """Return whitened readings (m, P) stop by stop, shape (n, r, P), zeros where a stop has fewer.

    Rows of zeros tell nothing: they change neither J'J nor the determinants by which stops are chosen.
    """
    counts = np.bincount(stop, minlength=n)
    rows = np.zeros((n, int(counts.max()), white.shape[1]))
    order = np.argsort(stop, kind="stable")
    within = np.arange(len(stop)) - np.repeat(np.cumsum(counts) - counts, counts)
    rows[stop[order], within] = white[order]
    return rows


def _rigid_motions(places_mm: FloatArray) -> FloatArray:
    """Return how places (m, 3) move with three shifts and three turns, shape (3 m, 6).

    Turns [mm/rad] are about the places' middle, which keeps the six columns well apart.
    """
    arms = places_mm - places_mm.mean(axis=0)
    shifts = [np.broadcast_to(axis, arms.shape) for axis in np.eye(3)]
    turns = [np.cross(axis, arms) for axis in np.eye(3)]
    return np.stack([motion.ravel() for motion in (*shifts, *turns)], axis=1)
