r"""Inverse of an identified model: the joint angles at which the real tool is where it shall be.

No closed form holds for a level-3 model. From the nominal answer, Newton's method turns the error of the
identified forward model into joint angles,

    q <- q + J(q)^-1 e(q),   e = (shift, turn) from the attained pose to the wanted one,

with J the geometric Jacobian of the identified chain. What J leaves out (springs, waves of a gear) changes a
step by a few per cent, hence each pass gains a factor of 30 or more. Three guards keep it sound: a step is no
longer than a fixed turn, it is halved while the error grows, and the equations are damped as long as the
error is large, so that a singularity shortens steps instead of blowing them up.

References
----------
A. Nubiola, thesis, ETS Montreal, 2014, section 1.5 (fake targets, pose shift).
Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986, 163-171 (damping near singularities).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.correction.goals import Goals
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.kinematics.frames import cross, vector_from_rotation

ARRIVED_MM: Final = 1e-3  # 1 um, and 1 urad: a hundredth of what robots repeat
ARRIVED_RAD: Final = 1e-6
_LEVER_MM: Final = 1000.0  # weighs turns against shifts: at it both limits are the same
_SURE: Final = 0.1  # of the limits, at which the iteration rests
_PASSES: Final = 8
_HALVINGS: Final = 3
_LONGEST_STEP_RAD: Final = 0.3
_DAMPING: Final = 1e-4  # of the squared error: no hindrance once the error is small
_ROUNDING: Final = 1e-13  # of the squared lever: keeps the equations of a singular arm solvable


@dataclass(frozen=True, slots=True)
class Attained(Table):
    """Where a search ended, n rows."""

    joints_rad: FloatArray  # (n, J)
    error_mm: FloatArray  # (n,) distance from the wanted position
    error_rad: FloatArray  # (n,) turn from the wanted orientation

    @property
    def distance(self) -> FloatArray:
        """Of both errors the one that is more of its limit, in limits, shape (n,)."""
        return np.maximum(self.error_mm / ARRIVED_MM, self.error_rad / ARRIVED_RAD)

    @property
    def arrived(self) -> BoolArray:
        """Which rows are within the limits, shape (n,)."""
        return np.asarray(self.distance <= 1.0)


def replaced(found: Attained, rows: IntArray, others: Attained) -> Attained:
    """Return what was found with other answers in some rows, shape (m,)."""
    columns = [found.joints_rad.copy(), found.error_mm.copy(), found.error_rad.copy()]
    for column, new in zip(columns, (others.joints_rad, others.error_mm, others.error_rad), strict=True):
        column[rows] = new
    return Attained(*columns)


def merged(found: Attained, rows: IntArray, again: Attained) -> Attained:
    """Return what was found, of some rows (m,) the nearer of two answers."""
    nearer = np.flatnonzero(again.distance < found.distance[rows])
    return replaced(found, rows[nearer], again.taken(nearer))


def attain(estimate: Estimate, goals: Goals, start_rad: FloatArray) -> Attained:
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
    Attained
        The nearest that each row came to its goal, whether it arrived or not; NaN and infinity where there
        was no start. Joint limits are not looked at.
    """
    ended = Attained(start_rad.copy(), np.full(len(goals), np.inf), np.full(len(goals), np.inf))
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
            search.narrow(np.flatnonzero(~resting))
    _keep(ended, left, search, np.ones(len(left), dtype=bool))
    return ended


def _keep(ended: Attained, rows: IntArray, search: "_Search", which: BoolArray) -> None:
    ended.joints_rad[rows] = search.joints[which]
    ended.error_mm[rows] = np.linalg.norm(search.error[which, :3], axis=1)
    ended.error_rad[rows] = np.linalg.norm(search.error[which, 3:], axis=1) / _LEVER_MM


class _Search:
    """Rows under way: the best joints of each, the error there, and the step that is tried from there."""

    def __init__(self, estimate: Estimate, goals: Goals, start_rad: FloatArray) -> None:
        self._estimate, self._goals = estimate, goals
        self._sign = np.array([row.sign for row in estimate.structure.robot.joints], dtype=float)
        self.joints = start_rad
        self.error = np.full((len(goals), 6), np.inf)
        self._step = np.zeros_like(start_rad)
        self._halvings = np.zeros(len(goals), dtype=np.int64)
        self._state: State | None = None

    def advance(self) -> None:
        """Try the steps; take those that helped and prepare the next one, halve the others."""
        trial = self.joints + self._step
        self._state = self._at(trial)
        error = _error(self._state, self._goals)
        better = _size(error) < _size(self.error)
        self.joints[better], self.error[better] = trial[better], error[better]
        self._step[~better] *= 0.5
        self._halvings = np.where(better, 0, self._halvings + 1)
        going = np.flatnonzero(better & ~_is_there(error))
        self._step[going] = _step(self._state, going, error[going], self._sign)

    def _at(self, joints_rad: FloatArray) -> State:
        targets = Targets(self._goals.at(joints_rad), self._goals.nest)
        return evaluate(self._estimate.structure, self._estimate.values, targets, self._state)

    def resting(self) -> BoolArray:
        """Return which rows arrived, or cannot come nearer."""
        return np.asarray(_is_there(self.error) | (self._halvings > _HALVINGS))

    def narrow(self, rows: IntArray) -> None:
        """Go on with some rows only."""
        self._goals, self._state = self._goals.taken(rows), None
        self.joints, self.error, self._step = self.joints[rows], self.error[rows], self._step[rows]
        self._halvings = self._halvings[rows]


def _size(error: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt((error**2).sum(axis=1)))


def _is_there(error: FloatArray) -> BoolArray:
    return np.asarray(_size(error) <= _SURE * ARRIVED_MM)


def _error(state: State, goals: Goals) -> FloatArray:
    """Return shift [mm] and turn [mm at the lever] from the attained poses to the goals, shape (n, 6)."""
    turn = vector_from_rotation(goals.rotation @ np.swapaxes(state.chain.end_rotation, 1, 2))
    return np.concatenate([goals.position_mm - state.unscaled_mm, _LEVER_MM * turn], axis=1)


def _step(state: State, rows: IntArray, error: FloatArray, sign: FloatArray) -> FloatArray:
    """Return damped Newton steps of some rows (m,), shape (m, J)."""
    axes, origins = state.chain.z[:, rows], state.chain.origin[:, rows]
    shift = cross(axes, state.unscaled_mm[rows] - origins)
    jacobian = np.concatenate([shift, _LEVER_MM * axes], axis=2).transpose(1, 2, 0) * sign
    transposed = np.swapaxes(jacobian, 1, 2)
    damping = _DAMPING * np.minimum((error**2).sum(axis=1), _LEVER_MM**2)
    across = jacobian @ transposed
    across += (damping + _ROUNDING * _LEVER_MM**2)[:, None, None] * np.eye(6)
    step = (transposed @ np.linalg.solve(across, error[:, :, None]))[:, :, 0]
    longest = np.abs(step).max(axis=1, keepdims=True)
    return np.asarray(step * np.minimum(1.0, _LONGEST_STEP_RAD / np.maximum(longest, _LONGEST_STEP_RAD)))
