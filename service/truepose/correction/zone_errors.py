"""What another description of the arm makes of the zone that was measured, against the full model."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Stops
from truepose.domain.results.identification import Model
from truepose.domain.robot import JointRange
from truepose.identification.model.estimates import identified_estimate, nominal_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.rigid import RigidArm
from truepose.identification.model.validity.zone import outside
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation

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

    None where nobody can say: the model knows no nest or no zone that holds any of them, or loads gears by
    torques that only the controller measures.
    """
    if model.zone is None or model.torques_measured or not model.nests:
        return None
    rng = np.random.default_rng(seed)
    joints = _drawn(model.zone.joint_ranges, rng)
    distance_mm, _ = outside(model.zone, model.robot, joints)
    joints = joints[distance_mm < _ON_THE_HULL_MM][:CONFIGURATIONS]
    if not len(joints):
        return None
    nests = np.array([nest.nest for nest in model.nests])
    rows = np.repeat(np.arange(len(joints)), len(nests))
    stops = Stops(rows + 1, joints[rows], direction=rng.choice([-1, 1], joints.shape)[rows])
    return Targets(stops, np.tile(nests, len(joints)))


def _drawn(ranges: tuple[JointRange, ...], rng: np.random.Generator) -> FloatArray:
    low, high = (np.array([getattr(r, end) for r in ranges]) for end in ("lower_rad", "upper_rad"))
    return rng.uniform(low, high, (_DRAWN, len(ranges)))


def placed(model: Model, targets: Targets) -> FloatArray:
    """Return where the model says that the nests are, shape (n, 3) [mm]."""
    estimate = identified_estimate(model)
    return evaluate(estimate.structure, estimate.values, targets).unscaled_mm


def rigidly_placed(arm: RigidArm, targets: Targets) -> FloatArray:
    """Return where a rigid arm's nests are, shape (n, 3) [mm]."""
    values = nominal_values(arm.robot, targets.stops.joints_rad)
    chain = forward(values, placement_rotation(arm.base), placement_translation(arm.base))
    return chain.points(_centres(arm)[_rows(arm, targets.nest)])


def _centres(arm: RigidArm) -> FloatArray:
    return np.array([nest.centre_mm for nest in arm.nests])


def _rows(arm: RigidArm, nest: IntArray) -> IntArray:
    return np.searchsorted([known.nest for known in arm.nests], nest)


def zone_error(model: Model, targets: Targets, other: Callable[[Targets], FloatArray]) -> ZoneError:
    """Compare another prediction of the nests with the model's."""
    apart = np.linalg.norm(other(targets) - placed(model, targets), axis=1)
    return ZoneError(float(apart.mean()), float(apart.max()))


def rigid_error(model: Model, arm: RigidArm, seed: int = 0) -> ZoneError | None:
    """Return how far the rigid part of a model is off the whole; None where nobody can say."""
    targets = zone_targets(model, seed)
    return None if targets is None else zone_error(model, targets, lambda at: rigidly_placed(arm, at))


def nominal_error(model: Model, seed: int = 0) -> ZoneError | None:
    """Return how far the nominal robot is off the model, base and unknown nests fitted; None as above."""
    targets = zone_targets(model, seed)
    return None if targets is None else zone_error(model, targets, lambda at: nominally_placed(model, at))


def nominally_placed(model: Model, targets: Targets) -> FloatArray:
    """Return where the nominal robot's nests are, base and unknown nests fitted, shape (n, 3) [mm]."""
    estimate = nominal_estimate(model)
    return evaluate(estimate.structure, estimate.values, targets).unscaled_mm
