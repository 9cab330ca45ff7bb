"""What a correction answers, goal by goal, and added up over a whole table of targets.

A search ends somewhere; here it is said what that is worth: whether the goal was reached within the limits,
how uncertain the tool's place is there, how far outside the measured zone, how far joints turn. Joints that
do not lead to their goal are not handed out (docs/decisions/0039).
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.correction.branches import NominalArm
from truepose.correction.inverse import SearchEnd
from truepose.correction.target_poses import FAR_RAD, Goals, beyond, turned_within
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.correction import CORRECTED, CorrectionTotals
from truepose.domain.identification import Model
from truepose.domain.robot import Robot
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import placed_variance, turned_variance
from truepose.identification.model.validity import outside
from truepose.kinematics.inverse import branch_of, has_closed_form

ANY_BRANCH: Final = -1
Status: TypeAlias = Literal["ok", "limits_unknown", "joint_limit", "out_of_reach", "singular"]


@dataclass(frozen=True, slots=True)
class Corrections(Table):
    """What goals came to, n rows of J joints; of one that is not `solved` errors and excesses of the nearest.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
        To be sent to the controller; NaN where not `solved`.
    branch : ndarray of int, shape (n,)
        Of the joints, as in `kinematics.inverse`; ANY_BRANCH where not `solved`, and of an arm without
        numbered branches.
    error_mm, error_rad : ndarray, shape (n,)
        Between the goal and where the model says that the tool goes.
    uncertainty_mm : ndarray, shape (n,)
        Standard, per axis, of where the tool really goes.
    uncertainty_rad : ndarray, shape (n,)
        Of the turn, of the parameters alone.
    outside_mm : ndarray, shape (n,)
        How far the flange frame is outside the measured zone; NaN: nobody said where that is.
    outside_rad : ndarray, shape (n, J)
        How far each joint is outside its measured range.
    moved_rad : ndarray, shape (n,)
        Largest change of a joint from the controller's own answer; NaN: it has none.
    beyond_limit_rad : ndarray, shape (n, J)
        How far a joint would have to pass its limit; 0 within, NaN: unknown.
    status : ndarray of str, shape (n,)
        Of Status.
    """

    joints_rad: FloatArray  # (n, J) to be sent to the controller; NaN where there is nothing to send
    branch: IntArray  # (n,) of the joints, as in `kinematics.inverse`; ANY_BRANCH where they have no number
    error_mm: FloatArray  # (n,) between the goal and where the model says that the tool goes
    error_rad: FloatArray  # (n,)
    uncertainty_mm: FloatArray  # (n,) standard, per axis, of where the tool really goes
    uncertainty_rad: FloatArray  # (n,) of the parameters alone
    outside_mm: FloatArray  # (n,) how far the flange frame is outside the measured zone; NaN: nobody said
    outside_rad: FloatArray  # (n, J) how far each joint is outside its measured range
    moved_rad: FloatArray  # (n,) largest change of a joint from the controller's own answer; NaN: it has none
    beyond_limit_rad: (
        FloatArray  # (n, J) how far a joint would have to pass its limit; 0 within; NaN: unknown
    )
    status: npt.NDArray[np.str_]  # (n,) of Status

    def __len__(self) -> int:
        return len(self.status)

    @property
    def solved(self) -> BoolArray:
        """Which goals were reached, shape (n,), within limits as far as these are known."""
        return np.isin(self.status, CORRECTED)


def stack_tables(parts: list[Corrections]) -> Corrections:
    """Return tables one below the other.

    Parameters
    ----------
    parts : list of Corrections
        One or more.
    """
    columns = {field.name: [getattr(part, field.name) for part in parts] for field in fields(Corrections)}
    return Corrections(**{name: np.concatenate(column) for name, column in columns.items()})


def judge_searches(
    model: Model, estimate: Estimate, goals: Goals, found: SearchEnd, told: BoolArray
) -> Corrections:
    """Judge where searches ended.

    Parameters
    ----------
    model : Model
    estimate : Estimate
        Of it, with the nests of the goals.
    goals : Goals
        n of them.
    found : SearchEnd
        n rows.
    told : ndarray of bool, shape (n,)
        Rows that were asked for with joints, and keep the whole turns of these.

    Returns
    -------
    Corrections
        n rows.
    """
    robot = estimate.structure.robot
    turned, _ = turned_within(robot.joint_limits, found.joints_rad)
    # Whoever tells joints means their whole turns as well.
    joints = np.where(told[:, None], found.joints_rad, turned)
    # Where nothing was found joints of zero are predicted in its place: such rows are not solved, and nobody
    # reads them.
    state = evaluate(
        estimate.structure, estimate.values, Targets(goals.at(np.nan_to_num(joints)), goals.nest)
    )
    passed = beyond(robot.joint_limits, joints)
    outside_mm, outside_rad = _outside(model, joints)
    # As the controller answers the pose as it is asked for: how far joints turn from there is what an
    # operator sees.
    own = _own_answers(estimate, goals)
    away = np.where(told, _largest(goals.stops.joints_rad, joints), _nearest(own, joints))
    status = _statuses(found, passed, own)
    # Somebody would send them.
    solved = np.isin(status, CORRECTED)
    return Corrections(
        joints_rad=np.where(solved[:, None], joints, np.nan),
        branch=np.where(solved, _branches(robot, joints), ANY_BRANCH),
        error_mm=found.error_mm,
        error_rad=found.error_rad,
        uncertainty_mm=np.sqrt(placed_variance(model, state)),
        uncertainty_rad=np.sqrt(turned_variance(model, state)),
        outside_mm=outside_mm,
        outside_rad=outside_rad,
        moved_rad=away,
        beyond_limit_rad=passed,
        status=status,
    )


def _branches(robot: Robot, joints_rad: FloatArray) -> IntArray:
    """Return the branch of each row, ANY_BRANCH of an arm without numbered branches, shape (n,)."""
    if not has_closed_form(robot):
        return np.full(len(joints_rad), ANY_BRANCH)
    return branch_of(robot, joints_rad)


def _outside(model: Model, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far places (n,) and joints (n, J) are outside the measured zone; NaN: nobody said."""
    if model.zone is None:
        return np.full(len(joints_rad), np.nan), np.full_like(joints_rad, np.nan)
    return outside(model.zone, model.robot, joints_rad)


def _own_answers(estimate: Estimate, goals: Goals) -> FloatArray:
    """Return what the controller itself would answer, in every branch, shape (n, 8, J); NaN where nothing."""
    arm = NominalArm(estimate)
    return arm.branches(arm.flange(goals), reach_out=False)


def _largest(first_rad: FloatArray, second_rad: FloatArray) -> FloatArray:
    """Return the largest difference of joint angles (..., J), shape (...)."""
    return np.asarray(np.abs(first_rad - second_rad).max(axis=-1))


def _nearest(own_rad: FloatArray, joints_rad: FloatArray) -> FloatArray:
    """Return how far joints are from the nearest of several answers, whole turns aside, shape (n,)."""
    # The controller counts whole turns in its own way; a turn more is no change of the arm.
    apart = np.mod(own_rad - joints_rad[:, None] + np.pi, 2 * np.pi) - np.pi
    nearest = np.nan_to_num(np.abs(apart).max(axis=2), nan=np.inf).min(axis=1)
    return np.where(np.isfinite(nearest), nearest, np.nan)


def _statuses(found: SearchEnd, passed: FloatArray, own: FloatArray) -> npt.NDArray[np.str_]:
    """Return a Status for each row; out of reach is what the controller has no answer to either.

    Parameters
    ----------
    found : SearchEnd
    passed : ndarray, shape (n, J)
        As of `goals.beyond`; NaN where a limit is unknown.
    own : ndarray, shape (n, 8, J)
        The controller's own answers, NaN where there is none.
    """
    # Where the controller reaches the goal and the search does not, an arm near a singularity is all that is
    # left.
    missed = np.where(np.isnan(own[..., 0]).all(axis=1), "out_of_reach", "singular")
    known = np.where((passed > 0.0).any(axis=1), "joint_limit", "ok")
    # Corrected all the same: a robot whose limits nobody knows would else never be.
    arrived = np.where(np.isnan(passed).any(axis=1), "limits_unknown", known)
    return np.where(found.arrived, arrived, missed)


MOST_NAMED: Final = 100


class Summary:
    """Counts and extremes of corrected targets; holds no rows but the names of the first that failed."""

    def __init__(self) -> None:
        self._statuses: Counter[str] = Counter()
        self._failed: list[tuple[str, str]] = []  # name and status, at most MOST_NAMED
        self._largest_error_mm = self._largest_uncertainty_mm = 0.0
        self._far_moved = 0  # solved targets at which a joint turns far from the controller's own answer
        self._largest_move_rad = 0.0
        self._outside = 0  # solved targets outside the measured zone
        self._farthest_outside_mm = self._farthest_outside_rad = 0.0
        self._zone_known = True
        self._uncertainty_mm = 0.0

    def add(self, names: Sequence[str], found: Corrections) -> None:
        """Count some rows.

        Parameters
        ----------
        names : sequence of str
            n of them.
        found : Corrections
            n rows.
        """
        self._statuses.update(found.status.tolist())
        # Names of the first hundred only: tables have millions of rows.
        failed = np.flatnonzero(~found.solved).tolist()
        self._failed += [
            (names[row], str(found.status[row])) for row in failed[: MOST_NAMED - len(self._failed)]
        ]
        solved = found.taken(np.flatnonzero(found.solved))
        self._largest_error_mm = max(self._largest_error_mm, float(solved.error_mm.max(initial=0.0)))
        largest = solved.uncertainty_mm.max(initial=self._largest_uncertainty_mm)
        self._largest_uncertainty_mm = float(largest)  # NaN where a model does not know its own
        self._uncertainty_mm += float(solved.uncertainty_mm.sum())
        moved = np.nan_to_num(solved.moved_rad)
        self._far_moved += int((moved > FAR_RAD).sum())
        self._largest_move_rad = max(self._largest_move_rad, float(moved.max(initial=0.0)))
        self._zone_known = self._zone_known and not np.isnan(solved.outside_mm).any()
        beyond = (solved.outside_mm > 0.0) | (solved.outside_rad > 0.0).any(axis=1)
        self._outside += int(beyond.sum())
        self._farthest_outside_mm = max(self._farthest_outside_mm, _largest_of(solved.outside_mm))
        self._farthest_outside_rad = max(self._farthest_outside_rad, _largest_of(solved.outside_rad))

    @property
    def totals(self) -> CorrectionTotals:
        """What was counted so far; the mean uncertainty is 0 where nothing was corrected."""
        solved = sum(self._statuses[status] for status in CORRECTED)
        return CorrectionTotals(
            statuses=dict(self._statuses),
            failed=tuple(self._failed),
            largest_error_mm=self._largest_error_mm,
            mean_uncertainty_mm=self._uncertainty_mm / max(solved, 1),
            largest_uncertainty_mm=self._largest_uncertainty_mm,
            far_moved=self._far_moved,
            largest_move_rad=self._largest_move_rad,
            outside=self._outside,
            farthest_outside_mm=self._farthest_outside_mm,
            farthest_outside_rad=self._farthest_outside_rad,
            zone_known=self._zone_known,
        )


def _largest_of(beyond: FloatArray) -> float:
    return float(np.nan_to_num(beyond).max(initial=0.0))
