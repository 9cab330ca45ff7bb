"""What a correction answers, goal by goal."""

from dataclasses import dataclass, fields
from typing import Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.correction.goals import Goals
from truepose.correction.inverse import Attained
from truepose.correction.limits import beyond, turned_within
from truepose.correction.starts import NominalArm
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.results import Model
from truepose.domain.robot import Robot
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import placed_variance, turned_variance
from truepose.identification.model.zone import outside
from truepose.kinematics.inverse import branch_of, has_closed_form

ANY_BRANCH: Final = -1
Status: TypeAlias = Literal["ok", "joint_limit", "out_of_reach", "singular"]


@dataclass(frozen=True, slots=True)
class Corrections(Table):
    """What goals came to, n rows of J joints; of a goal that cannot be reached the nearest that was found."""

    joints_rad: FloatArray  # (n, J) to be sent to the controller; NaN where there is nothing to send
    branch: IntArray  # (n,) of the joints, as in `kinematics.inverse`; ANY_BRANCH where they have no number
    error_mm: FloatArray  # (n,) between the goal and where the model says that the tool goes
    error_rad: FloatArray  # (n,)
    uncertainty_mm: FloatArray  # (n,) standard, per axis, of where the tool really goes
    uncertainty_rad: FloatArray  # (n,) of the parameters alone
    outside_mm: FloatArray  # (n,) how far the last frame is outside the measured zone; NaN: nobody said
    outside_rad: FloatArray  # (n, J) how far each joint is outside its measured range
    beyond_limit_rad: FloatArray  # (n, J) how far a joint would have to pass its limit; 0 within
    status: npt.NDArray[np.str_]  # (n,) of Status

    def __len__(self) -> int:
        return len(self.status)

    @property
    def solved(self) -> BoolArray:
        """Which goals were reached, shape (n,)."""
        return np.asarray(self.status == "ok")


def joined(parts: list[Corrections]) -> Corrections:
    """Return tables one below the other."""
    columns = {field.name: [getattr(part, field.name) for part in parts] for field in fields(Corrections)}
    return Corrections(**{name: np.concatenate(column) for name, column in columns.items()})


def judged(model: Model, estimate: Estimate, goals: Goals, found: Attained, told: BoolArray) -> Corrections:
    """Judge where searches ended; `told` rows keep the whole turns that they were asked for with."""
    robot = estimate.structure.robot
    turned, _ = turned_within(robot.joint_limits, found.joints_rad)
    joints = np.where(told[:, None], found.joints_rad, turned)
    state = evaluate(
        estimate.structure, estimate.values, Targets(goals.at(np.nan_to_num(joints)), goals.nest)
    )
    passed = beyond(robot.joint_limits, joints)
    outside_mm, outside_rad = _outside(model, joints)
    return Corrections(
        joints_rad=joints,
        branch=_branches(robot, joints),
        error_mm=found.error_mm,
        error_rad=found.error_rad,
        uncertainty_mm=np.sqrt(placed_variance(model, state)),
        uncertainty_rad=np.sqrt(turned_variance(model, state)),
        outside_mm=outside_mm,
        outside_rad=outside_rad,
        beyond_limit_rad=passed,
        status=_statuses(found, np.asarray(passed.any(axis=1)), ~_reaches(estimate, goals)),
    )


def _branches(robot: Robot, joints_rad: FloatArray) -> IntArray:
    if not has_closed_form(robot):
        return np.full(len(joints_rad), ANY_BRANCH)
    return branch_of(robot, joints_rad)


def _outside(model: Model, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    if model.zone is None:
        return np.full(len(joints_rad), np.nan), np.full_like(joints_rad, np.nan)
    return outside(model.zone, model.robot, joints_rad)


def _reaches(estimate: Estimate, goals: Goals) -> BoolArray:
    """Whether the nominal arm reaches a goal in any branch, shape (n,)."""
    arm = NominalArm(estimate)
    exists = np.isfinite(arm.branches(arm.flange(goals), reach_out=False)[..., 0])
    return np.asarray(exists.any(axis=1))


def _statuses(found: Attained, beyond_limit: BoolArray, too_far: BoolArray) -> npt.NDArray[np.str_]:
    """Return a Status for each row."""
    missed = np.where(too_far, "out_of_reach", "singular")
    arrived = np.where(beyond_limit, "joint_limit", "ok")
    return np.where(found.arrived, arrived, missed)
