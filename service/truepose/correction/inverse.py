r"""Inverse of an identified model: the joint angles at which the real tool is where it shall be.

No closed form holds for a level-3 model. From the nominal answer, Newton's method turns the error of the
identified forward model into joint angles,

    q <- q + J^T (J J^T + lambda 1)^-1 e,   e = (shift, L turn) from the attained pose to the wanted one,

with J the geometric Jacobian of the identified chain, turns weighed by the lever L, and

    lambda = 1e-4 min(|e|^2, L^2) + rounding

Of six joints and lambda = 0 this is J^-1 e, of more the least turn. What J leaves out (springs, waves of a
gear) changes a step by a few per cent, hence each pass gains a factor of 30 or more. Three guards keep it
sound: a step is no longer than a fixed turn, it is halved while the error grows, and the equations are damped
as long as the error is large, so that a singularity shortens steps instead of blowing them up.

Many arms step at once. Components come first and rows last, as in the chain: six equations are then
eliminated by some sixty operations on whole columns, several times faster than one small system after the
other.

References
----------
Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986, 163-171 (damping near singularities).
A. Nubiola, thesis, ETS Montreal, 2014, section 1.5 (fake targets, pose shift).
docs/decisions/0039 (what was measured, and why not pose shift alone).
"""

from dataclasses import dataclass, fields, replace
from typing import Final, NamedTuple

import numpy as np

from truepose.correction.target_poses import Goals
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import Load, State, Targets, evaluate_once
from truepose.kinematics.frames import cross, vector_from_rotation

LEVER_MM: Final = 1000.0  # weighs turns against shifts
_LONGEST_STEP_RAD: Final = 0.3
_DAMPING: Final = 1e-4  # of the squared error: no hindrance once the error is small
_ROUNDING: Final = 1e-13  # of the squared lever: keeps the equations of a singular arm solvable


def damped_steps(state: State, rows: IntArray, error: FloatArray, sign: FloatArray) -> FloatArray:
    """Return what joints have to turn by so that an error goes; of more than six joints, the least turn.

    Parameters
    ----------
    state : State
        At n targets.
    rows : ndarray of int, shape (m,)
        Of the state.
    error : ndarray, shape (m, 6)
        Shift [mm] and turn [mm at the lever] that are left to go.
    sign : ndarray, shape (J,)
        Of the joints.

    Returns
    -------
    ndarray, shape (m, J)
        [rad], of controller angles, none longer than 0.3 rad.
    """
    jacobian = _jacobian(state, rows, sign)
    damping = _DAMPING * np.minimum((error**2).sum(axis=1), LEVER_MM**2) + _ROUNDING * LEVER_MM**2
    weights = _solved(_normal(jacobian, damping), error.T.copy())
    step = np.einsum("ijn,in->nj", jacobian, weights)
    longest = np.abs(step).max(axis=1, keepdims=True, initial=_LONGEST_STEP_RAD)
    # The whole step is shortened, not the one joint: its direction is what leads towards the goal.
    return np.asarray(step * (_LONGEST_STEP_RAD / longest))


def _jacobian(state: State, rows: IntArray, sign: FloatArray) -> FloatArray:
    """Return shifts [mm] and turns [mm at the lever] per angle of each joint, shape (6, J, m).

    Column i: sign_i (z_i x (p - o_i), L z_i), p the nest where it is and not where an instrument sees it.
    """
    axes, origins = state.chain.z[:, rows], state.chain.origin[:, rows]
    jacobian = np.empty((6, *axes.shape[:2]))
    jacobian[:3] = np.moveaxis(cross(axes, state.unscaled_mm[rows] - origins), 2, 0)
    np.multiply(np.moveaxis(axes, 2, 0), LEVER_MM, out=jacobian[3:])
    jacobian *= sign[:, None]
    return jacobian


def _normal(jacobian: FloatArray, damping: FloatArray) -> FloatArray:
    """Return J J^T with a damped diagonal, shape (6, 6, m); its upper half is not filled in."""
    normal = np.empty((6, *jacobian.shape[::2]))
    for i, row in enumerate(jacobian):
        np.multiply(row[0], jacobian[: i + 1, 0], out=normal[i, : i + 1])
        for joint in range(1, len(row)):
            normal[i, : i + 1] += row[joint] * jacobian[: i + 1, joint]
        normal[i, i] += damping
    return normal


def _solved(normal: FloatArray, right: FloatArray) -> FloatArray:
    """Solve positive definite equations, of which the lower half counts, (6, 6, m), for (6, m); in place.

    Elimination without pivots, which a positive definite matrix does not need.
    """
    for k in range(6):
        share = normal[k + 1 :, k] / normal[k, k]
        for i in range(k + 1, 6):
            normal[i, k + 1 : i + 1] -= share[i - k - 1] * normal[k + 1 : i + 1, k]
        right[k + 1 :] -= share * right[k]
    for k in reversed(range(6)):
        for i in range(k + 1, 6):
            right[k] -= normal[i, k] * right[i]
        right[k] /= normal[k, k]
    return right


ARRIVED_MM: Final = 1e-3  # 1 um, and 1 urad: a hundredth of what robots repeat
ARRIVED_RAD: Final = 1e-6  # at the lever of a step the same
_SURE: Final = 0.1  # of the limits, at which the iteration rests
_PASSES: Final = 8
_HALVINGS: Final = 3
# Torques that differ so much from those of the step before, of the largest, are worked out once more: of a
# deflection of 0.1 deg 2e-8 rad are then missing, or a hundredth of the error that is left.
_AT_REST: Final = 1e-5
_SETTLING_MM: Final = 0.002


@dataclass(frozen=True, slots=True)
class SearchEnd(Table):
    """Where a search ended, n rows.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
    error_mm : ndarray, shape (n,)
        Distance from the wanted position.
    error_rad : ndarray, shape (n,)
        Turn from the wanted orientation.
    astray : ndarray of bool, shape (n,)
        Whether joints are of no use, however near the arm is: another branch, far turned.
    """

    joints_rad: FloatArray  # (n, J)
    error_mm: FloatArray  # (n,) distance from the wanted position
    error_rad: FloatArray  # (n,) turn from the wanted orientation
    astray: (
        BoolArray  # (n,) whether joints are of no use, however near the arm is: another branch, far turned
    )

    @property
    def distance(self) -> FloatArray:
        """Of both errors the one that is more of its limit, in limits, shape (n,); infinite astray."""
        away = np.maximum(self.error_mm / ARRIVED_MM, self.error_rad / ARRIVED_RAD)
        # However near the arm is there: an answer in another branch would turn the wrist on the way.
        return np.where(self.astray, np.inf, away)

    def without(self, useless: BoolArray) -> "SearchEnd":
        """Return the same with some rows, shape (n,), gone astray."""
        return replace(self, astray=self.astray | useless)

    @property
    def arrived(self) -> BoolArray:
        """Which rows are within the limits, shape (n,)."""
        return np.asarray(self.distance <= 1.0)


def with_rows_replaced(found: SearchEnd, rows: IntArray, others: SearchEnd) -> SearchEnd:
    """Return what was found with other answers in some rows.

    Parameters
    ----------
    found : SearchEnd
        n rows.
    rows : ndarray of int, shape (m,)
    others : SearchEnd
        m rows.
    """
    columns = {field.name: getattr(found, field.name).copy() for field in fields(SearchEnd)}
    for name, column in columns.items():
        column[rows] = getattr(others, name)
    return SearchEnd(**columns)


def nearer_of(found: SearchEnd, rows: IntArray, again: SearchEnd) -> SearchEnd:
    """Return what was found, of some rows the nearer of two answers.

    Parameters
    ----------
    found : SearchEnd
        n rows.
    rows : ndarray of int, shape (m,)
    again : SearchEnd
        m rows.
    """
    nearer = np.flatnonzero(again.distance < found.distance[rows])
    return with_rows_replaced(found, rows[nearer], again.taken(nearer))


def attain(estimate: Estimate, goals: Goals, start_rad: FloatArray) -> SearchEnd:
    """Search the joint angles at which an identified arm is at its goals.

    Parameters
    ----------
    estimate : Estimate
        Of an arm with six joints or more; of more, the joints move least from their start.
    goals : Goals
        n poses, of nests of the estimate.
    start_rad : ndarray, shape (n, J)
        Rows with NaN are not searched.

    Returns
    -------
    SearchEnd
        The nearest that each row came to its goal, whether it arrived or not; NaN and infinity where there
        was no start. Joint limits are not looked at.
    """
    n = len(goals)
    # What is not searched stays at infinity, so that any answer of another search is nearer.
    ended = SearchEnd(start_rad.copy(), np.full(n, np.inf), np.full(n, np.inf), np.zeros(n, dtype=bool))
    left = np.flatnonzero(np.isfinite(start_rad).all(axis=1))
    search = _Search(estimate, goals.taken(left), start_rad[left])
    for _ in range(_PASSES):
        if not len(left):
            break
        search.advance()
        resting = search.resting()
        if resting.any():
            _keep(ended, left[resting], search, resting)
            left = left[~resting]
            # Rows that rest are dropped: most are there after three passes, and would be predicted five more
            # times.
            search.narrow(np.flatnonzero(~resting))
    _keep(ended, left, search, np.ones(len(left), dtype=bool))
    return ended


def _keep(ended: SearchEnd, rows: IntArray, search: "_Search", which: BoolArray) -> None:
    ended.joints_rad[rows] = search.joints[which]
    ended.error_mm[rows] = np.linalg.norm(search.error[which, :3], axis=1)
    ended.error_rad[rows] = np.linalg.norm(search.error[which, 3:], axis=1) / LEVER_MM


class _Tried(NamedTuple):
    """Trials of n rows."""

    joints: FloatArray  # (n, J)
    error: FloatArray  # (n, 6)
    state: State


class _Search:
    """Rows under way: the best joints of each, the error there, and the step that is tried from there."""

    def __init__(self, estimate: Estimate, goals: Goals, start_rad: FloatArray) -> None:
        self._estimate, self._goals = estimate, goals
        self._sign = np.array([row.sign for row in estimate.structure.robot.joints], dtype=float)
        self.joints = start_rad
        self.error = np.full((len(goals), 6), np.inf)
        self._step = np.zeros_like(start_rad)
        self._halvings = np.zeros(len(goals), dtype=np.int64)
        self._load: Load | None = None  # of the last trial

    def advance(self) -> None:
        """Try the steps; take those that helped and prepare the next one, halve the others."""
        trial = self.joints + self._step
        tried, self._load, imbalance = self._tried(self._goals, trial, self._load)
        # Far from the goal a load need not be better known than the error that is left to go.
        settled = imbalance <= _AT_REST * np.maximum(1.0, _size(tried.error) / _SETTLING_MM)
        places = np.flatnonzero(settled)
        self._judge(places, tried, places)
        rest = np.flatnonzero(~settled)
        # Only the rows whose torques had not settled: a step of the others is not worked out twice.
        if self._load and len(rest):
            tried, load, _ = self._tried(self._goals.taken(rest), trial[rest], self._load.taken(rest))
            # The frames stay those of the first look, which are near enough for the levers of weights.
            self._load = self._load.with_torques(rest, load)
            self._judge(rest, tried, np.arange(len(rest)))

    def _tried(
        self, goals: Goals, joints_rad: FloatArray, load: Load | None
    ) -> tuple["_Tried", Load | None, FloatArray]:
        """Predict trial joints under a load that is nearly theirs.

        Parameters
        ----------
        goals : Goals
            m rows.
        joints_rad : ndarray, shape (m, J)
        load : Load or None
            Of the same rows at the trial before.

        Returns
        -------
        tried : _Tried
        load : Load or None
            Of the arm where it is.
        imbalance : ndarray, shape (m,)
            Of its torques, of the largest torque [1].
        """
        targets = Targets(goals.at(joints_rad), goals.nest)
        estimate = self._estimate
        # Under the load of the trial before, which is nearly this one's: one pass of forward kinematics
        # instead of two or three. With steps solved by columns this took 10,000 targets from 138 to 88 ms.
        state, own, imbalance = evaluate_once(estimate.structure, estimate.values, targets, load)
        return _Tried(joints_rad, _error(state, goals), state), own, imbalance

    def _judge(self, rows: IntArray, tried: "_Tried", places: IntArray) -> None:
        """Take what was tried for some rows, and prepare their next step.

        Parameters
        ----------
        rows : ndarray of int, shape (m,)
            Under way.
        tried : _Tried
        places : ndarray of int, shape (m,)
            Where these rows stand in it.
        """
        error = tried.error[places]
        # The first trial of a row is always better than infinity, and has no step: it is the start itself.
        better = _size(error) < _size(self.error[rows])
        won, lost = rows[better], rows[~better]
        self.joints[won], self.error[won] = tried.joints[places[better]], error[better]
        self._halvings[won], self._halvings[lost] = 0, self._halvings[lost] + 1
        # The step before was worked out where the error was smaller: its direction still leads downhill, its
        # length does not.
        self._step[lost] *= 0.5
        going = better & ~_is_there(error)
        self._step[rows[going]] = damped_steps(tried.state, places[going], error[going], self._sign)

    def resting(self) -> BoolArray:
        """Return which rows arrived, or cannot come nearer."""
        return np.asarray(_is_there(self.error) | (self._halvings > _HALVINGS))

    def narrow(self, rows: IntArray) -> None:
        """Go on with some rows only."""
        self._goals, self._load = self._goals.taken(rows), self._load and self._load.taken(rows)
        self.joints, self.error, self._step = self.joints[rows], self.error[rows], self._step[rows]
        self._halvings = self._halvings[rows]


def _size(error: FloatArray) -> FloatArray:
    """Return the length of errors (n, 6), turns at the lever, shape (n,) [mm]."""
    return np.asarray(np.sqrt((error**2).sum(axis=1)))


def _is_there(error: FloatArray) -> BoolArray:
    """Say which errors (n, 6) are below a tenth of the limits."""
    return np.asarray(_size(error) <= _SURE * ARRIVED_MM)


def _error(state: State, goals: Goals) -> FloatArray:
    """Return shift [mm] and turn [mm at the lever] from the attained poses to the goals, shape (n, 6)."""
    turn = vector_from_rotation(goals.rotation @ np.swapaxes(state.chain.end_rotation, 1, 2))
    return np.concatenate([goals.position_mm - state.unscaled_mm, LEVER_MM * turn], axis=1)
