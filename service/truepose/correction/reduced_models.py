"""Reduced models: what other programs and controllers can take of a model, and the error that leaves.

The nearest arm: the full model says where the nests are in configurations of the zone; the nominal robot is
fitted to these with the parameters that the other side has, least squares without weights,

    min over p of  sum |rigid(p, q_k) - full(q_k)|^2

What the other side lacks, such as springs, goes into these parameters as far as it can.

A controller takes joint zeros, base and tool. It keeps its maker's table, so that only these are fitted to
the full model over the measured zone. Other configurations of the zone judge what is left.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, PointReadings, Stops
from truepose.domain.errors import UnsuitableModelError
from truepose.domain.identification import Model, NestCentre
from truepose.domain.robot import FramePlacement, JointRange, Nest
from truepose.effects.frames.base_frame import NAME as BASE
from truepose.effects.frames.tool_nests import NAME as TOOL
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification.fit.robust import RobustFit, fit
from truepose.identification.model.estimates import RigidArm, identified_estimate, nominal_estimate, rigid_arm
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import placed_variance
from truepose.identification.model.validity import outside
from truepose.identification.model_of_fit import Fits, model_of
from truepose.identification.problem.build import Problem, build
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_of, placement_rotation, placement_translation

CONFIGURATIONS: Final = 400
_DRAWN: Final = 20 * CONFIGURATIONS  # the box of joint ranges is larger than the hull of the places in it

_ON_THE_HULL_MM: Final = 1e-6  # rounding puts places that span the hull outside of it


@dataclass(frozen=True, slots=True)
class ZoneError:
    """How far predictions of nests are apart over a zone [mm]."""

    mean_mm: float
    max_mm: float


def zone_targets(model: Model, seed: int) -> Targets | None:
    """Return configurations spread over the measured zone, with every nest, each joint come from either side.

    Parameters
    ----------
    model : Model
    seed : int
        The same seed gives the same configurations.

    Returns
    -------
    Targets or None
        At most 400 configurations, drawn evenly over the joint ranges within the hull of places. None where
        nobody can say: the model knows no nest or no zone that holds any of them, or loads gears by torques
        that only the controller measures.
    """
    if model.zone is None or model.torques_measured or not model.nests:
        return None
    rng = np.random.default_rng(seed)
    joints = _drawn(model.zone.joint_ranges, rng)
    distance_mm, _ = outside(model.zone, model.robot, joints)
    # The box of joint ranges reaches places where nobody measured; a fit to those would spoil it where it
    # counts.
    joints = joints[distance_mm < _ON_THE_HULL_MM][:CONFIGURATIONS]
    if not len(joints):
        return None
    nests = np.array([nest.nest for nest in model.nests])
    # Backlash is part of what a rigid arm lacks: with one direction for all it would hide in the joint zeros.
    rows = np.repeat(np.arange(len(joints)), len(nests))
    stops = Stops(rows + 1, joints[rows], direction=rng.choice([-1, 1], joints.shape)[rows])
    return Targets(stops, np.tile(nests, len(joints)))


def _drawn(ranges: tuple[JointRange, ...], rng: np.random.Generator) -> FloatArray:
    """Return joints (8000, J) [rad], drawn evenly over ranges."""
    low, high = (np.array([getattr(r, end) for r in ranges]) for end in ("lower_rad", "upper_rad"))
    return rng.uniform(low, high, (_DRAWN, len(ranges)))


def nest_positions(model: Model, targets: Targets) -> FloatArray:
    """Return where the model says that the nests are, shape (n, 3) [mm], world.

    Parameters
    ----------
    model : Model
    targets : Targets
        n of them.
    """
    estimate = identified_estimate(model)
    return evaluate(estimate.structure, estimate.values, targets).unscaled_mm


def rigidly_placed(arm: RigidArm, targets: Targets) -> FloatArray:
    """Return where a rigid arm's nests are, shape (n, 3) [mm], world.

    Parameters
    ----------
    arm : RigidArm
        With the nests of the targets, by ascending number.
    targets : Targets
        n of them.
    """
    values = nominal_values(arm.robot, targets.stops.joints_rad)
    chain = forward(values, placement_rotation(arm.base), placement_translation(arm.base))
    return chain.points(_centres(arm)[_rows(arm, targets.nest)])


def _centres(arm: RigidArm) -> FloatArray:
    return np.array([nest.centre_mm for nest in arm.nests])


def _rows(arm: RigidArm, nest: IntArray) -> IntArray:
    return np.searchsorted([known.nest for known in arm.nests], nest)


def zone_error(model: Model, targets: Targets, other: Callable[[Targets], FloatArray]) -> ZoneError:
    """Compare another prediction of the nests with the model's.

    Parameters
    ----------
    model : Model
    targets : Targets
        n of them.
    other : callable
        Targets to places (n, 3) [mm], world.
    """
    apart = np.linalg.norm(other(targets) - nest_positions(model, targets), axis=1)
    return ZoneError(float(apart.mean()), float(apart.max()))


def rigid_error(model: Model, arm: RigidArm, seed: int = 0) -> ZoneError | None:
    """Return how far the rigid part of a model is off the whole; None where nobody can say.

    Parameters
    ----------
    model : Model
    arm : RigidArm
    seed : int, optional
        Of `zone_targets`.
    """
    targets = zone_targets(model, seed)
    return None if targets is None else zone_error(model, targets, lambda at: rigidly_placed(arm, at))


def nominal_error(model: Model, seed: int = 0) -> ZoneError | None:
    """Return how far the nominal robot is off the model, base and unknown nests fitted.

    Parameters
    ----------
    model : Model
    seed : int, optional
        Of `zone_targets`.

    Returns
    -------
    ZoneError or None
        None as of `zone_targets`.
    """
    targets = zone_targets(model, seed)
    return None if targets is None else zone_error(model, targets, lambda at: nominally_placed(model, at))


def nominally_placed(model: Model, targets: Targets) -> FloatArray:
    """Return where the nominal robot's nests are, base and unknown nests fitted.

    Parameters
    ----------
    model : Model
    targets : Targets
        n of them.

    Returns
    -------
    ndarray, shape (n, 3)
        [mm], world.
    """
    estimate = nominal_estimate(model)
    return evaluate(estimate.structure, estimate.values, targets).unscaled_mm


# The same for all, and far below what the priors allow: they hold only what no configuration shows.
_STATED_MM: Final = 0.01


def nearest_arm(model: Model, targets: Targets, effects: tuple[str, ...]) -> RigidArm:
    """Return the nominal robot with the effects' parameters that come nearest to a model.

    Parameters
    ----------
    model : Model
    targets : Targets
        Configurations of the zone, each with every nest.
    effects : tuple of str
        Rigid ones: base, tool, geometry, joint_offset.

    Returns
    -------
    RigidArm
        `left_out` names what the model has beside its own rigid part.
    """
    campaign = _as_readings(model, targets)
    # The same solver as for readings, with a campaign of the model's own places: base, tool and nests are
    # placed without a guess, whatever the model says.
    problem = build(campaign, effects)
    fitted = model_of(Fits(campaign, *_evenly(problem)), discrepancy_mm=0.0, program_version="")
    return replace(rigid_arm(fitted), left_out=rigid_arm(model).left_out, uncertainty=_unknown(model))


def _as_readings(model: Model, targets: Targets) -> Campaign:
    # The rigid arm that is fitted knows no direction, and no effect of it asks for one.
    """Return a campaign whose readings are the model's own predictions, of a robot without scatter."""
    stops = replace(targets.stops, direction=None)
    stated = np.full(len(targets), _STATED_MM)
    readings = PointReadings(stops, targets.nest, nest_positions(model, targets), stated)
    # Places of a model do not scatter.
    robot = replace(model.robot, repeatability_mm=0.0)
    return Campaign(robot, None, tuple(Nest(None) for _ in model.nests), calibration=readings)


def _evenly(problem: Problem) -> tuple[RobustFit, RobustFit, np.ndarray]:
    """Return the fit in which every place counts the same, twice, and a covariance that says nothing."""
    solution = fit(problem.structure, problem.blocks, problem.start)
    none = (np.zeros(len(problem.blocks[0].weights), dtype=bool),)
    # Without weights: what a rigid arm lacks is no outlier, and the largest errors are to be made smaller
    # too.
    even = RobustFit(problem.structure, problem.blocks, solution, none, float("nan"))
    return even, even, np.zeros((len(problem.structure.specs),) * 2)


def _unknown(model: Model) -> tuple[dict[str, float], ...]:
    return tuple({} for _ in model.robot.joints)


PARAMETERS: Final = (BASE, TOOL, *effects_with(Trait.ZEROS))
_FIT_SEED, _JUDGE_SEED = 1, 2
_ON_A_LINE: Final = 1e-3  # sine of the angle at nest 1 below which three nests show no plane


@dataclass(frozen=True, slots=True)
class ControllerValues:
    """Values to type into a controller, and what they come to over the measured zone.

    Attributes
    ----------
    joint_zeros_rad : tuple of float
        True angle minus the angle that the controller shows.
    base : FramePlacement
        Of the robot in the frame of the readings.
    world : FramePlacement
        Of the frame of the readings in the robot's base: a work object.
    tool_points : tuple of NestCentre
        In the controller's flange frame.
    tool_frame : FramePlacement or None
        Nest 1, x to nest 2, nest 3 in the plane of x and y.
    nominal : ZoneError
        Against the full model: the nominal robot, base and unknown nests fitted.
    controller : ZoneError
        Against the full model: with these values.
    model : ZoneError
        The full model against the robot, as its own uncertainty lets expect.
    """

    joint_zeros_rad: tuple[float, ...]  # true angle minus the angle that the controller shows
    base: FramePlacement  # of the robot in the frame of the readings
    world: FramePlacement  # of the frame of the readings in the robot's base: a work object
    tool_points: tuple[NestCentre, ...]  # in the controller's flange frame
    tool_frame: FramePlacement | None  # nest 1, x to nest 2, nest 3 in the plane of x and y
    nominal: ZoneError  # against the full model: the nominal robot, base and unknown nests fitted
    controller: ZoneError  # against the full model: with these values
    model: ZoneError  # the full model against the robot, as its own uncertainty lets expect


def controller_values(model: Model) -> ControllerValues:
    """Find the best values of a controller's own parameters.

    Parameters
    ----------
    model : Model

    Returns
    -------
    ControllerValues

    Raises
    ------
    UnsuitableModelError
        The model does not say where it was measured, or needs torques that only the controller measures.
    """
    # Judged at other configurations than those that were fitted, else what is left would be told too small.
    seen, judged = zone_targets(model, _FIT_SEED), zone_targets(model, _JUDGE_SEED)
    if seen is None or judged is None:
        raise UnsuitableModelError(
            "The model does not state its measured zone, or needs torques that only the controller measures. "
            "Identify again with this version, without torques."
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
    """Return the joint zeros: sign_i times the difference of the fitted and the nominal offset [rad].

    theta = sign q + offset is the same for the true angle with the nominal offset as for the shown one with
    the fitted.
    """
    rows = zip(arm.robot.joints, model.robot.joints, strict=True)
    return tuple(row.sign * (row.theta_offset_rad - nominal.theta_offset_rad) for row, nominal in rows)


def _inverse(placement: FramePlacement) -> FramePlacement:
    back = placement_rotation(placement).T
    return placement_of(back, -back @ placement_translation(placement))


def three_point_frame(points_mm: FloatArray) -> FramePlacement | None:
    """Return the frame of the first three points: origin, a place on x, the side of y.

    Parameters
    ----------
    points_mm : ndarray, shape (k, 3)

    Returns
    -------
    FramePlacement or None
        None of fewer than three points, and of three on a line.
    """
    if len(points_mm) < 3:
        return None
    to_second, to_third = points_mm[1] - points_mm[0], points_mm[2] - points_mm[0]
    normal = np.cross(to_second, to_third)
    if np.linalg.norm(normal) <= _ON_A_LINE * np.linalg.norm(to_second) * np.linalg.norm(to_third):
        return None
    x, z = to_second / np.linalg.norm(to_second), normal / np.linalg.norm(normal)
    return placement_of(np.column_stack([x, np.cross(z, x), z]), points_mm[0])


def _expected(model: Model, targets: Targets) -> ZoneError:
    """Return the error that the model's own uncertainty lets expect, on average and where it is largest.

    The mean length of a normal vector with standard deviation s along three axes is s sqrt(8 / pi) (Maxwell's
    distribution).
    """
    estimate = identified_estimate(model)
    variance = placed_variance(model, evaluate(estimate.structure, estimate.values, targets))
    # The mean length of a normal vector with the same standard deviation along three axes.
    lengths = np.sqrt(8.0 / np.pi * variance)
    return ZoneError(float(lengths.mean()), float(lengths.max()))
