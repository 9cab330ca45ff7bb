"""Ballbar sessions: which poses, and what accuracy their lengths promise, in the frame of the cups.

With R the whitened derivatives of the lengths of the first n poses, K what priors, set-ups and sides tell,
and M = K + R'R, an identification weighs readings as they are stated. They err otherwise (the zero of the
ballbar walks after each initialisation); N is the scatter of the sums that it forms. Then

    C = M^-1 N M^-1        e = G C^1/2 z,   C^1/2 = M^-1 L with N = L L'

are the covariance of arm and cups, and the errors of predicted places in the frame of the cups. Poses are
chosen in the order in which they lower tr(W C) most (`planning.ballbar.choice`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import BallbarPlan, Leg, PlannedPlacement, PlannedPose
from truepose.domain.cell import BallbarKit, Cell, KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NotIdentifiable
from truepose.identification.verdict.identifiability import undetermined_by_configurations
from truepose.planning.ballbar.arm_model import ArmModel, Scatter, arm_model
from truepose.planning.ballbar.bodies import BaseFixture
from truepose.planning.ballbar.expected_information import WorkSpaceSample, error_gradient, error_weight
from truepose.planning.ballbar.placements import PlacementRequest, suggest
from truepose.planning.ballbar.plan import ballbar_cell
from truepose.planning.ballbar.pose_selection import (
    candidates,
    information_after,
    least_error_first,
    of_candidates,
    require_candidates,
    stacked_rows,
)
from truepose.planning.ballbar.poses import setups
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.prediction.errors import (
    MOST,
    NONE,
    CurvePoint,
    Discrepancy,
    Errors,
    curve,
    knee,
    sizes,
)
from truepose.planning.prediction.expected_covariance import LEAST_MM
from truepose.planning.prediction.plan import (
    VOLUME_CONFIGURATIONS,
    Assumptions,
    BallbarPoses,
    PromisedPlan,
    WorkVolume,
    because_of,
    indices,
    parameters_of,
    require_some,
    sample,
)
from truepose.planning.tracker.plans import short_tour
from truepose.planning.workspace.capsules import look_at
from truepose.planning.workspace.space import WorkSpace, space_of_cell, without_tracker

_DRAWS: Final = 120  # random places of the base fixture: the search takes some seconds
_MOVES: Final = 50
_STREAM: Final = 3  # of random numbers: poses are chosen for other places than the promise is computed at
_USUAL: Final = 40  # poses that a place should offer: the thesis of A. Nubiola has 39 there, section 3.5
_MOVED_RAD: Final = np.deg2rad(0.5)  # a joint that stays within this has not moved


def promised_ballbar_session(
    cell: Cell,
    n: int | None = None,
    *,
    volume: WorkVolume | None = None,
    discrepancy: Discrepancy = NONE,
    placements: int = 1,
    seed: int = 0,
) -> PromisedPlan:
    """Choose the poses of a ballbar session and say what accuracy they promise.

    Parameters
    ----------
    cell : Cell
    n : int, optional
        Poses to measure; by default as many as the knee of the curve says.
    volume : WorkVolume, optional
        Where accuracy counts; by default the joint ranges in which configurations are chosen.
    discrepancy : Discrepancy
    placements : int
        How often the base fixture is put down.
    seed : int
        The same seed gives the same plan.

    Returns
    -------
    PromisedPlan
        Errors count in the frame that the cups define.

    Raises
    ------
    ConfigurationError
        The cell lacks what a ballbar needs, or fewer than one pose, or than one a placement, is asked for.
    WorkSpaceError, TooFewCandidatesError
        The arm does not offer that many poses, or has no place in the volume.
    """
    require_some(n)
    base_points = 3 if cell.ballbar is None else cell.ballbar.base_points
    wish = PlacementRequest(placements, base_points, n or _USUAL, draws=_DRAWS, moves=_MOVES, seed=seed)
    fixtures = suggest(ballbar_cell(cell), wish).fixtures
    return plan_with_fixtures(cell, fixtures, n, volume=volume, discrepancy=discrepancy, seed=seed)


def plan_with_fixtures(
    cell: Cell,
    fixtures: Sequence[BaseFixture],
    n: int | None = None,
    *,
    volume: WorkVolume | None = None,
    discrepancy: Discrepancy = NONE,
    seed: int = 0,
) -> PromisedPlan:
    """Plan with the base fixture at given places.

    Parameters
    ----------
    cell : Cell
    fixtures : sequence of BaseFixture
        In the order of their placements, numbered from 1.
    n : int, optional
        Poses to measure; by default as many as the knee of the curve says.
    volume, discrepancy, seed
        As in `promised_ballbar_session`.

    Returns
    -------
    PromisedPlan

    Raises
    ------
    ConfigurationError, WorkSpaceError
        As `promised_ballbar_session`; the arm cannot hold the setting ball at a cup.
    TooFewCandidatesError
        More poses were asked for than can be measured from there, or nothing can from a placement.
    """
    rng = np.random.default_rng(seed)
    # What no parameter expresses moves the tool at a stop, as the arm's own scatter does: all its lengths
    # share it.
    stop = float(np.hypot(cell.robot.repeatability_mm, discrepancy.per_axis_mm))
    kit, limits = cell.ballbar or BallbarKit(), ballbar_cell(cell)
    # An uncertainty of 0 would weigh infinitely.
    length_mm = max(float(np.hypot(kit.reading_u_mm, kit.zero_u_mm)), LEAST_MM)
    scatter = Scatter(stop, length_mm, max(kit.setup_u_mm, LEAST_MM), length_mm, kit.zero_u_mm)
    # Nests taken for exact promised 5 % too low over 300 simulated cells.
    certified = [nest.standard_uncertainty_mm or 0.0 for nest in cell.nests]
    model = arm_model(limits, scatter, certified)
    # Poses are chosen for other places than the promise is computed at: it would flatter a choice that
    # suits its own sample.
    weighed = _places(cell, volume or WorkVolume(), model, np.random.default_rng([seed, _STREAM]))
    choice = _choice(model, fixtures, weighed, max(MOST, n or 0))
    if n is not None and n > len(choice.rows):
        raise TooFewCandidatesError(
            f"{n} poses were requested, but only {len(choice.rows)} can be measured from these placements. "
            f"Request fewer poses, or more placements of the base fixture.{look_at(limits.keep_outs)}"
        )
    numbers = sizes(n, len(choice.rows))
    places = _places(cell, volume or WorkVolume(), model, rng)
    gradient = error_gradient(choice.cups_mm, places)
    errors = Errors(lambda size: gradient @ choice.root(size), discrepancy, cell.robot.repeatability_mm)
    points = curve(errors, numbers)
    advised = knee(points)
    size = advised if n is None else n

    def open_without(keep_outs: KeepOuts) -> frozenset[str]:
        free = arm_model(replace(limits, keep_outs=keep_outs), scatter, certified)
        return parameters_of(_choice(free, fixtures, weighed, size).left_open(free, size))

    plan = choice.plan(model, size, points, advised, discrepancy)
    return replace(plan, left_open=because_of(limits.keep_outs, plan.left_open, open_without))


def session_plan(cell: Cell, plan: PromisedPlan) -> BallbarPlan:
    """Return the session that measures a plan, without ways from stop to stop.

    Parameters
    ----------
    cell : Cell
    plan : PromisedPlan

    Returns
    -------
    BallbarPlan
        To be listed and timed: nobody has looked for ways, so that it is none to be run.

    Raises
    ------
    ConfigurationError
        The plan is of positions.
    WorkSpaceError
        The arm cannot hold the setting ball at a cup.
    """
    if plan.poses is None:
        raise ConfigurationError(
            "The plan is for position measurements; a ballbar session cannot measure them."
        )
    limits, poses = ballbar_cell(cell), plan.poses
    return BallbarPlan(
        tuple(
            PlannedPlacement(
                fixture.number,
                fixture.frame,
                tuple((float(x), float(y), float(z)) for x, y, z in fixture.cups_mm),
                setups(limits, fixture),
                _planned_poses(plan.joints_rad, poses, fixture.number),
            )
            for fixture in poses.fixtures
        )
    )


def _planned_poses(joints_rad: FloatArray, poses: BallbarPoses, placement: int) -> tuple[PlannedPose, ...]:
    return tuple(
        PlannedPose(row + 1, placement, tuple(joints_rad[row].tolist()), poses.legs[row])
        for row in np.flatnonzero(poses.placement == placement).tolist()
    )


@dataclass(frozen=True, slots=True)
class _Choice:
    """Poses of all placements in the order in which they were chosen; arm first, then all cups.

    Notes
    -----
    poses of L lengths each; P parameters of the arm and its certified nests, C cups. All columns are per
    prior width.
    """

    joints_rad: FloatArray  # (N, J)
    legs: tuple[tuple[Leg, ...], ...]
    placement: IntArray  # (N,)
    rows: FloatArray  # (N, L, P + 3 C) whitened, per prior width
    known: FloatArray  # (P + 3 C, P + 3 C) information of priors, set-ups and sides
    erring_rows: FloatArray  # as rows, of readings as they err
    erring_known: FloatArray  # as known, of readings as they err
    cups_mm: FloatArray  # (C, 3)
    fixtures: tuple[BaseFixture, ...]

    def information(self, size: int) -> FloatArray:
        """Return M, what is known after so many poses, shape (P + 3 C, P + 3 C)."""
        flat = self.rows[:size].reshape(-1, self.rows.shape[2])
        return np.asarray(self.known + flat.T @ flat)

    def root(self, size: int) -> FloatArray:
        """Return a root of the covariance after so many poses, shape (P + 3 C, P + 3 C).

        Readings are weighed as they are stated and err as they do: with information M and the scatter N of
        the sums that an identification forms, the covariance is M^-1 N M^-1.
        """
        flat = self.erring_rows[:size].reshape(-1, self.erring_rows.shape[2])
        sums = np.linalg.cholesky(self.erring_known + flat.T @ flat)
        return np.asarray(np.linalg.solve(self.information(size), sums))

    def plan(
        self,
        model: ArmModel,
        size: int,
        points: tuple[CurvePoint, ...],
        advised: int,
        discrepancy: Discrepancy,
    ) -> PromisedPlan:
        """Return the plan of the first `size` poses, placement by placement on short ways."""
        order = self._in_order(size)
        reading = model.scatter.leg_mm
        return PromisedPlan(
            joints_rad=self.joints_rad[order],
            nest=None,
            poses=BallbarPoses(tuple(self.legs[row] for row in order), self.placement[order], self.fixtures),
            curve=points,
            advised=advised,
            measured=0,
            left_open=self.left_open(model, size),
            # Of the arm alone: cups and certificates belong to this session.
            observability=indices(self.rows[:size, :, : model.own_parameters], size),
            assumptions=Assumptions(
                reading, model.cell.robot.repeatability_mm, discrepancy, model.cell.keep_outs.names
            ),
        )

    def _in_order(self, size: int) -> IntArray:
        # Placement by placement: to put the base fixture down again takes a person, and its cups are
        # clamped and measured anew.
        parts = []
        for number in np.unique(self.placement[:size]):
            own = np.flatnonzero(self.placement[:size] == number)
            parts.append(own[short_tour(self.joints_rad[own])])
        return np.concatenate(parts)

    def left_open(self, model: ArmModel, size: int) -> tuple[NotIdentifiable, ...]:
        """Return what so many poses leave open."""
        arm, widths = slice(model.parameters), model.structure.prior_widths
        covariance = np.linalg.inv(self.information(size))[arm, arm] * np.outer(widths, widths)
        flat = self.rows[:size, :, arm].reshape(-1, model.parameters)
        moved = np.ptp(self.joints_rad[:size], axis=0) > _MOVED_RAD
        return undetermined_by_configurations(model.structure, covariance, flat.T / widths[:, None], moved)


def _choice(model: ArmModel, fixtures: Sequence[BaseFixture], weighed: WorkSpaceSample, most: int) -> _Choice:
    """Return `most` poses in the order of choice, all where there are no more."""
    held = [setups(model.cell, fixture) for fixture in fixtures]
    offers = [candidates(model, fixture, own) for fixture, own in zip(fixtures, held, strict=True)]
    require_candidates(offers)
    # Weighed as they err, poses would be chosen for an identification that nobody runs.
    erring = replace(model, erring=True)
    true = [of_candidates(erring, offer, own) for offer, own in zip(offers, held, strict=True)]
    known, erring_known = (
        information_after(one, own, [np.zeros(0, dtype=np.int64)] * len(own))
        for one, own in ((model, offers), (erring, true))
    )
    rows = stacked_rows(model, offers, len(known.matrix))
    # By the error over the volume: up to 8 % less of it is promised than in the order of O1
    # (docs/decisions/0043).
    order = least_error_first(rows, most, known.matrix, error_weight(known.cups_mm, weighed))
    legs = [legs for own in offers for legs in own.found.legs]
    return _Choice(
        joints_rad=np.concatenate([own.found.joints_rad for own in offers])[order],
        legs=tuple(legs[row] for row in order),
        placement=np.repeat([own.fixture.number for own in offers], [len(own) for own in offers])[order],
        rows=rows[order],
        known=known.matrix,
        erring_rows=stacked_rows(erring, true, len(known.matrix))[order],
        erring_known=erring_known.matrix,
        cups_mm=known.cups_mm,
        fixtures=tuple(fixtures),
    )


def work_space_of(cell: Cell) -> WorkSpace:
    """Return the work space of a ballbar, which sees a nest from everywhere.

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    WorkSpace

    Raises
    ------
    ConfigurationError, WorkSpaceError
        As `planning.ballbar.plan.ballbar_cell`.
    """
    return without_tracker(space_of_cell(cell, ballbar_cell(cell).ranges, None))


def _places(cell: Cell, volume: WorkVolume, model: ArmModel, rng: np.random.Generator) -> WorkSpaceSample:
    found = sample(work_space_of(cell), volume, VOLUME_CONFIGURATIONS, rng)
    position, motion = model.nests(found.joints_rad)
    each = np.arange(len(found))
    return WorkSpaceSample(position[each, found.nest - 1], motion[each, found.nest - 1])
