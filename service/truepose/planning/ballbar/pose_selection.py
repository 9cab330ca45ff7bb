r"""Which configurations of all placements are measured: by observability, then by the predicted error.

O1 asks how well parameters are known, whichever they are; a user asks how well positions are. With C the
covariance of all parameters and W the mean square gradient of the positions in them, the figure is tr(W C). A
configuration b with whitened rows J_b that leaves, and a that enters, change it by

    C' = C + C J_b' (I - J_b C J_b')^-1 J_b C
    tr W C'' = tr W C' - tr (I + J_a C' J_a')^-1 J_a C' W C' J_a'

The second line is Woodbury's identity for M + J_a' J_a, C = M^-1, under the trace.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.ballbar import PlannedSetup
from truepose.kinematics.pose_device import Assembly
from truepose.planning.ballbar.arm_model import ArmModel
from truepose.planning.ballbar.bodies import BaseFixture
from truepose.planning.ballbar.expected_information import (
    PoseRows,
    SessionInformation,
    WorkSpaceSample,
    error_weight,
    information_beforehand,
    of_poses,
    pose_rows,
    setting_information,
    with_placement,
)
from truepose.planning.ballbar.poses import ReachablePoses, reach
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.exchange_algorithm import choose_by_exchange
from truepose.planning.observability import best_first

_SMALLEST_GAIN: Final = 1e-4  # of the figure: an exchange that brings less is not worth its time
_MOST_EXCHANGES: Final = 60
_MOST_LEAVING: Final = 12  # members that are tried before the exchange ends; the rest is missed even more


def exchanged_for_error(
    rows: FloatArray, chosen: IntArray, known: FloatArray, weight: FloatArray
) -> IntArray:
    """Exchange configurations as long as the mean square error of predicted positions falls.

    Parameters
    ----------
    rows : ndarray, shape (N, L, P)
        Whitened derivatives of all candidates.
    chosen : ndarray, shape (n,)
        Indices to start from.
    known : ndarray, shape (P, P)
        Information that there is without any of them, positive definite.
    weight : ndarray, shape (P, P)
        Mean of g g' over the work space, g the gradient of a position in the parameters.

    Returns
    -------
    ndarray, shape (n,)
        Ascending.
    """
    member = np.zeros(len(rows), dtype=bool)
    member[chosen] = True
    for _ in range(_MOST_EXCHANGES):
        if member.all() or not _exchange(rows, member, known, weight):
            break
    return np.flatnonzero(member).astype(np.int64)


def least_error_first(rows: FloatArray, n: int, known: FloatArray, weight: FloatArray) -> IntArray:
    """Choose n configurations one after another: every next one lowers the mean square error most.

    Parameters as above; all are taken where there are no more.

    Parameters
    ----------
    rows : ndarray, shape (N, L, P)
        As in `exchanged_for_error`.
    n : int
        All are taken where there are no more.
    known, weight : ndarray, shape (P, P)
        As in `exchanged_for_error`.

    Returns
    -------
    ndarray, shape (min(n, N),)
        Indices in the order of choice.
    """
    before = np.asarray(np.linalg.inv(known), dtype=float)
    return best_first(rows, n, before, lambda covariance: _changes(rows, covariance, weight, 1.0))


def _exchange(rows: FloatArray, member: BoolArray, known: FloatArray, weight: FloatArray) -> bool:
    # Inverted anew at each exchange, which are few: nothing that rounding could add up is carried on.
    own = rows[member].reshape(-1, rows.shape[2])
    covariance: FloatArray = np.asarray(np.linalg.inv(own.T @ own + known), dtype=float)
    figure = float(np.sum(weight * covariance))
    members, others = np.flatnonzero(member), np.flatnonzero(~member)
    missed = _changes(rows[members], covariance, weight, -1.0)
    for leaving in members[np.argsort(missed)][:_MOST_LEAVING]:
        without = _without(covariance, rows[leaving])
        gains = _changes(rows[others], without, weight, 1.0)
        best = int(np.argmax(gains))
        if float(np.sum(weight * without)) - gains[best] < figure * (1.0 - _SMALLEST_GAIN):
            member[leaving], member[others[best]] = False, True
            return True
    return False


def _without(covariance: FloatArray, left: FloatArray) -> FloatArray:
    """Return C' = C + C J' (I - J C J')^-1 J C, the covariance once a configuration has left, shape (P, P).

    I - J C J' is positive definite as long as the information without it is, which priors and set-ups make
    it.
    """
    seen = covariance @ left.T
    return np.asarray(covariance + seen @ np.linalg.solve(np.eye(len(left)) - left @ seen, seen.T))


def _changes(rows: FloatArray, covariance: FloatArray, weight: FloatArray, sign: float) -> FloatArray:
    """How much the figure changes with each configuration that enters (+1) or leaves (-1), shape (n,).

    tr (I +- J C J')^-1 J C W C J' for each: it falls by that with one that enters, and rises with one that
    leaves.
    """
    n, lines, columns = rows.shape
    seen = (rows.reshape(-1, columns) @ covariance).reshape(n, lines, columns)
    own = np.eye(lines) + sign * seen @ np.swapaxes(rows, 1, 2)
    moved = (seen.reshape(-1, columns) @ weight).reshape(n, lines, columns) @ np.swapaxes(seen, 1, 2)
    return np.asarray(np.trace(np.linalg.solve(own, moved), axis1=1, axis2=2))


@dataclass(frozen=True, slots=True)
class Candidates:
    """What can be measured from one placement.

    Attributes
    ----------
    fixture : BaseFixture
    found : ReachablePoses
        n configurations.
    rows : PoseRows
        Of their legs.
    setting : ndarray, shape (P + 3 K, P + 3 K)
        Information of priors, set-ups and sides.
    """

    fixture: BaseFixture
    found: ReachablePoses
    rows: PoseRows
    setting: FloatArray

    def __len__(self) -> int:
        return len(self.found)


def candidates(
    model: ArmModel,
    fixture: BaseFixture,
    setups: Sequence[PlannedSetup] | None = None,
    made: Sequence[Assembly] | None = None,
) -> Candidates:
    """Return all measurable configurations of a placement with what they say.

    Parameters
    ----------
    model : ArmModel
    fixture : BaseFixture
    setups : sequence of PlannedSetup, optional
        One a cup; without them the cups are known by their sides alone.
    made : sequence of Assembly, optional
        What `poses.device` returns, where many placements are looked at.

    Returns
    -------
    Candidates
    """
    found = reach(model.cell, fixture, made)
    return _with_rows(model, fixture, found, setups)


def require_candidates(placements: Sequence[Candidates]) -> None:
    """Raise where nothing can be measured from a placement: its cups would be clamped for nothing.

    Parameters
    ----------
    placements : sequence of Candidates

    Raises
    ------
    TooFewCandidatesError
    """
    for own in placements:
        if not len(own):
            raise TooFewCandidatesError(
                f"No configuration can be measured from placement {own.fixture.number}. Move the base "
                "fixture, or let the program suggest a position."
            )


def of_candidates(
    model: ArmModel, offer: Candidates, setups: Sequence[PlannedSetup] | None = None
) -> Candidates:
    """Return what the same configurations say by another model of the arm.

    Parameters
    ----------
    model : ArmModel
    offer : Candidates
    setups : sequence of PlannedSetup, optional
        As in `candidates`.

    Returns
    -------
    Candidates
    """
    return _with_rows(model, offer.fixture, offer.found, setups)


def _with_rows(
    model: ArmModel, fixture: BaseFixture, found: ReachablePoses, setups: Sequence[PlannedSetup] | None
) -> Candidates:
    joints = None if setups is None else np.array([setup.joints_rad for setup in setups])
    return Candidates(
        fixture,
        found,
        pose_rows(model, fixture.cups_mm, found.joints_rad, found.legs),
        setting_information(model, fixture.cups_mm, joints),
    )


def information_after(
    model: ArmModel, placements: Sequence[Candidates], chosen: Sequence[IntArray | None], n: int | None = None
) -> SessionInformation:
    """Return what a session will know.

    Parameters
    ----------
    model : ArmModel
    placements : sequence of Candidates
    chosen : sequence of ndarray or None
        Configurations of each placement; None: all of them, weighed as if there were its share of `n`.
    n : int, optional
        Configurations of the whole session, where some are not chosen yet.

    Returns
    -------
    SessionInformation
    """
    known = information_beforehand(model)
    for own, rows in zip(placements, chosen, strict=True):
        # Places are compared before anything is chosen there: one with more candidates must not look
        # better than its share of the session can make it.
        weight = 1.0 if rows is not None or n is None else n / len(placements) / max(1, len(own))
        information = own.setting + of_poses(own.rows, rows, weight)
        known = with_placement(known, information, own.fixture.cups_mm)
    return known


def choose(
    model: ArmModel,
    placements: Sequence[Candidates],
    n: int,
    rng: np.random.Generator,
    sample: WorkSpaceSample | None = None,
) -> tuple[IntArray, ...]:
    """Choose n configurations of all placements together, by observability, then by the error that is left.

    Parameters
    ----------
    model : ArmModel
    placements : sequence of Candidates
    n : int
    rng : numpy.random.Generator
        Draws the start.
    sample : WorkSpaceSample, optional
        Where errors count; without it the choice rests on O1 alone.

    Returns
    -------
    tuple of ndarray
        Indices into the candidates of each placement, ascending; all of them where there are no more than n.

    Raises
    ------
    ConfigurationError
        Fewer than one configuration was asked for.
    """
    counts = [len(own) for own in placements]
    if sum(counts) <= n:
        return tuple(np.arange(count, dtype=np.int64) for count in counts)
    prior = information_after(model, placements, [np.zeros(0, dtype=np.int64)] * len(placements))
    rows = stacked_rows(model, placements, len(prior.matrix))
    chosen = choose_by_exchange(rows, n, rng, prior_information=prior.matrix).indices
    if sample is not None:
        weight = error_weight(prior.cups_mm, sample)
        chosen = exchanged_for_error(rows, chosen, prior.matrix, weight)
    ends = np.cumsum(counts)
    return tuple(
        chosen[(chosen >= end - count) & (chosen < end)] - (end - count)
        for count, end in zip(counts, ends, strict=True)
    )


def stacked_rows(model: ArmModel, placements: Sequence[Candidates], columns: int) -> FloatArray:
    """Return the whitened derivatives of all candidates in arm and all cups.

    Parameters
    ----------
    model : ArmModel
    placements : sequence of Candidates
        One at least; N configurations together.
    columns : int
        P + 3 C, with the C cups of all placements.

    Returns
    -------
    ndarray, shape (N, L, columns)
        Zeros for the cups of other placements, and in rows that a configuration has not.
    """
    total, legs = sum(len(own) for own in placements), max(own.rows.arm.shape[1] for own in placements)
    stacked = np.zeros((total, legs, columns))
    # The arm is the same at all placements, the cups are each placement's own.
    row, column = 0, model.parameters
    for own in placements:
        n, lines, width = own.rows.cups.shape
        stacked[row : row + n, :lines, : model.parameters] = own.rows.arm
        stacked[row : row + n, :lines, column : column + width] = own.rows.cups
        row, column = row + n, column + width
    return stacked
