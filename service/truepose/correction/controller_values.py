"""What a controller can take: joint zeros, base and tool, as near to the model as they come.

A controller keeps its maker's table, so that only these are fitted to the full model over the measured zone.
Other configurations of the zone judge what is left.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.correction.zone_errors import (
    ZoneError,
    nominally_placed,
    rigidly_placed,
    zone_error,
    zone_targets,
)
from truepose.correction.zone_fit import nearest_arm
from truepose.domain.arrays import FloatArray
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.results.identification import Model, NestCentre
from truepose.domain.robot import FramePlacement
from truepose.effects.base.base_frame import NAME as BASE
from truepose.effects.links.geometry import JointOffset
from truepose.effects.tool.tool_nests import NAME as TOOL
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import placed_variance
from truepose.identification.model.rigid import RigidArm
from truepose.kinematics.frames import placement_of, placement_rotation, placement_translation

PARAMETERS: Final = (BASE, TOOL, JointOffset.name)
_FIT_SEED, _JUDGE_SEED = 1, 2
_ON_A_LINE: Final = 1e-3  # sine of the angle at nest 1 below which three nests show no plane


@dataclass(frozen=True, slots=True)
class ControllerValues:
    """Values to type into a controller, and what they come to over the measured zone."""

    joint_zeros_rad: tuple[float, ...]  # true angle minus the angle that the controller shows
    base: FramePlacement  # of the robot in the frame of the readings
    world: FramePlacement  # of the frame of the readings in the robot's base: a work object
    tool_points: tuple[NestCentre, ...]  # in the controller's last frame
    tool_frame: FramePlacement | None  # nest 1, x to nest 2, nest 3 in the plane of x and y
    nominal: ZoneError  # against the full model: the nominal robot, base and unknown nests fitted
    controller: ZoneError  # against the full model: with these values
    model: ZoneError  # the full model against the robot, as its own uncertainty lets expect


def controller_values(model: Model) -> ControllerValues:
    """Find the best values of a controller's own parameters.

    Raises
    ------
    UnsuitableModelError
        The model does not say where it was measured, or needs torques that only the controller measures.
    """
    seen, judged = zone_targets(model, _FIT_SEED), zone_targets(model, _JUDGE_SEED)
    if seen is None or judged is None:
        raise UnsuitableModelError(
            "The model does not know its measured zone, or needs torques that only the controller measures: "
            "identify again with this version, without torques."
        )
    arm = nearest_arm(model, seen, PARAMETERS)
    return ControllerValues(
        joint_zeros_rad=_zeros(model, arm),
        base=arm.base,
        world=_inverse(arm.base),
        tool_points=arm.nests,
        tool_frame=three_point_frame(np.array([nest.centre_mm for nest in arm.nests])),
        nominal=zone_error(model, judged, lambda at: nominally_placed(model, at)),
        controller=zone_error(model, judged, lambda at: rigidly_placed(arm, at)),
        model=_expected(model, judged),
    )


def _zeros(model: Model, arm: RigidArm) -> tuple[float, ...]:
    rows = zip(arm.robot.joints, model.robot.joints, strict=True)
    return tuple(row.sign * (row.theta_offset_rad - nominal.theta_offset_rad) for row, nominal in rows)


def _inverse(placement: FramePlacement) -> FramePlacement:
    back = placement_rotation(placement).T
    return placement_of(back, -back @ placement_translation(placement))


def three_point_frame(points_mm: FloatArray) -> FramePlacement | None:
    """Return the frame of the first three points, shape (k, 3): origin, a place on x, the side of y."""
    if len(points_mm) < 3:
        return None
    to_second, to_third = points_mm[1] - points_mm[0], points_mm[2] - points_mm[0]
    normal = np.cross(to_second, to_third)
    if np.linalg.norm(normal) <= _ON_A_LINE * np.linalg.norm(to_second) * np.linalg.norm(to_third):
        return None
    x, z = to_second / np.linalg.norm(to_second), normal / np.linalg.norm(normal)
    return placement_of(np.column_stack([x, np.cross(z, x), z]), points_mm[0])


def _expected(model: Model, targets: Targets) -> ZoneError:
    """Return the error that the model's own uncertainty lets expect, on average and where it is largest."""
    estimate = identified_estimate(model)
    variance = placed_variance(model, evaluate(estimate.structure, estimate.values, targets))
    # The mean length of a normal vector with the same standard deviation along three axes.
    lengths = np.sqrt(8.0 / np.pi * variance)
    return ZoneError(float(lengths.mean()), float(lengths.max()))
