"""Where a model holds: the robot, the zone and the time that were measured.

*Zone:* ranges of the joints, and a polytope around the places of the flange. The polytope has a face for
every direction to a face, an edge or a corner of a cube, 26 in all: a hull of fixed size that needs no points
kept, a little larger than the convex one.

*Time:* before the first or after the last reading nobody followed what drifts. A drift may go on or stop. Its
state is held where the readings left it, and its uncertainty grows as that of a local linear trend, a slope
with a random walk on top (Harvey 1989), both as large as the campaign shows. Beyond it the slope is unknown:
its mean is 0, its mean square that of the fitted slope r, with the variance of the estimate. Whether it stays
or changes, it takes the drift no farther than r t in t hours, root mean square (Cauchy and Schwarz). The walk
comes as far as the drift did, r T, in the T hours of a campaign. Thus

    u^2 = (r t)^2 + (r T)^2 t / T = r^2 t (t + T).

A row that does not tell its time counts as one a campaign's length beyond, t = T.

References
----------
A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, Cambridge, 1989.
"""

from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import MeasuredZone, Model
from truepose.domain.robot import JointRange, Robot
from truepose.effects.motions import SECONDS_PER_HOUR
from truepose.effects.registry import is_unbounded_in_time
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.structure import Structure
from truepose.kinematics.chain import nominal_chain
from truepose.messages.message import Message, message

_SAME_ROW: Final = 1e-6  # mm or rad: files round tables no further


def require_same_robot(model: Model, robot: Robot) -> None:
    """Raise where a model's nominal robot is another one.

    Parameters
    ----------
    model : Model
    robot : Robot

    Raises
    ------
    ConfigurationError
        Another number of joints, or a quantity of a row differs by more than 1e-6 mm or rad.
    """
    ours = model.robot
    if ours.n_joints != robot.n_joints:
        raise ConfigurationError(
            f"The model has {ours.n_joints} joints, but this robot has {robot.n_joints}; the model is of a "
            "different robot."
        )
    # Rows are named by where the tables differ most: a person looks there first.
    away = np.abs(ours.table - robot.table).max(axis=1)
    if away.max() > _SAME_ROW:
        raise ConfigurationError(
            f"Row {int(np.argmax(away)) + 1} of the model's nominal table differs from that of this cell's "
            "robot: the model is of a different robot, or the table has been changed since."
        )


_CUBE = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
DIRECTIONS: Final = _CUBE / np.linalg.norm(_CUBE, axis=1, keepdims=True)  # (26, 3)


def measured_zone(robot: Robot, joints_rad: FloatArray) -> MeasuredZone:
    """Return the zone of configurations that were measured.

    Parameters
    ----------
    robot : Robot
        Nominal.
    joints_rad : ndarray, shape (n, J)
        n >= 1.

    Returns
    -------
    MeasuredZone
        Ranges of the joints [rad], and how far out the flange frame's origin came along each of the 26
        directions [mm, base of the robot].
    """
    low, high = joints_rad.min(axis=0), joints_rad.max(axis=0)
    # Ranges alone would count corners of their box that no configuration was near; hence places besides.
    ranges = tuple(JointRange(*ends) for ends in zip(low.tolist(), high.tolist(), strict=True))
    return MeasuredZone(ranges, tuple(_along(robot, joints_rad).max(axis=0).tolist()))


def outside(zone: MeasuredZone, robot: Robot, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far configurations are outside the zone, at least.

    Parameters
    ----------
    zone : MeasuredZone
    robot : Robot
        Nominal, whose zone it is.
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    distance_mm : ndarray, shape (n,)
        Of the flange frame's origin from the polytope; 0 within.
    angle_rad : ndarray, shape (n, J)
        Of each joint from its range; 0 within.
    """
    place_mm = nominal_chain(robot, joints_rad).end_origin
    low, high = (np.array([getattr(r, end) for r in zone.joint_ranges]) for end in ("lower_rad", "upper_rad"))
    beyond_rad = np.maximum(low - joints_rad, joints_rad - high)
    return beyond_zone_mm(zone, place_mm), np.maximum(beyond_rad, 0.0)


def beyond_zone_mm(zone: MeasuredZone, place_mm: FloatArray) -> FloatArray:
    """Return how far places of the flange frame are outside the polytope, at least.

    Parameters
    ----------
    zone : MeasuredZone
    place_mm : ndarray, shape (n, 3)
        In the robot's base.

    Returns
    -------
    ndarray, shape (n,)
        The largest distance beyond a face [mm]; beside an edge or a corner the zone is farther. 0 within.
    """
    # The distance from a polytope is that from its farthest face, at least.
    beyond = (place_mm @ DIRECTIONS.T - np.array(zone.extents_mm)).max(axis=1)
    return np.asarray(np.maximum(beyond, 0.0))


def _along(robot: Robot, joints_rad: FloatArray) -> FloatArray:
    """Return how far out the flange frame is in each direction, shape (n, 26) [mm]."""
    return np.asarray(nominal_chain(robot, joints_rad).end_origin @ DIRECTIONS.T)


def held_effect_sentences(structure: Structure, targets: Targets) -> tuple[Message, ...]:
    """Return one sentence for every effect that is held in some rows because nobody followed it there.

    Parameters
    ----------
    structure : Structure
        Of a made model, whose `last_s` is known.
    targets : Targets
    """
    # NaN, of rows without a time, is not above 0: `left_out` tells of these.
    hours = hours_beyond(structure, targets.stops)
    rows = int((hours > 0.0).sum())
    if rows == 0:
        return ()
    return tuple(
        message("cautions.held", effect=effect, rows=rows, targets=len(targets))
        for effect in _going_on(structure)
    )


def held_effect_variance(
    structure: Structure, values: FloatArray, covariance: FloatArray, targets: Targets
) -> FloatArray:
    """Return the variance per axis that drifts add beyond the readings, mean of the three.

    Parameters
    ----------
    structure : Structure
        Of a made model, whose `last_s` is known.
    values : ndarray, shape (P,)
        Internal units.
    covariance : ndarray, shape (P, P)
        Of the values.
    targets : Targets
        n of them.

    Returns
    -------
    ndarray, shape (n,)
        r^2 t (t + T) [mm2] with t and T in hours; 0 between the first and the last reading.
    """
    variance, lasted_h = np.zeros(len(targets)), _lasted_h(structure)
    # Nobody says when such a row is; decision 0028 takes it for a campaign's length after the last one.
    hours = np.nan_to_num(hours_beyond(structure, targets.stops), nan=lasted_h)
    rows = np.flatnonzero(hours > 0.0)
    if rows.size and _going_on(structure):
        square = _mean_square_per_h(structure, values, covariance, targets.taken(rows))
        variance[rows] = square * hours[rows] * (hours[rows] + lasted_h)
    return variance


def _mean_square_per_h(
    structure: Structure, values: FloatArray, covariance: FloatArray, targets: Targets
) -> FloatArray:
    """Mean square per axis of what drifts move each position by in an hour, shape (n,) [mm2/h2]."""
    # Rows without a time stand where the last reading left the robot: what an hour more makes of them is r.
    later = replace(targets, stops=replace(targets.stops, time_s=None))
    longer = replace(structure, last_s=(structure.last_s or 0.0) + SECONDS_PER_HOUR)
    before, after = evaluate(structure, values, later), evaluate(longer, values, later)
    way = after.position_mm - before.position_mm
    # What an hour more makes of the derivatives is the derivative of the rate.
    change = position_jacobian(after) - position_jacobian(before)
    estimate = np.einsum("pni,pq,qni->n", change, covariance, change, optimize=True)
    return np.asarray(((way**2).sum(axis=1) + estimate) / 3.0)


def _going_on(structure: Structure) -> tuple[str, ...]:
    return tuple(
        effect for effect in structure.effects if is_unbounded_in_time(effect, structure.names_of(effect))
    )


def hours_beyond(structure: Structure, stops: Stops) -> FloatArray:
    """Return the time from the nearest reading of a model, 0 between them, NaN where it is unknown.

    Parameters
    ----------
    structure : Structure
        Of a made model, whose `last_s` is known.
    stops : Stops
        n of them.

    Returns
    -------
    ndarray, shape (n,)
        [h]
    """
    if stops.time_s is None or structure.last_s is None:
        return np.full(len(stops), np.nan)
    # Within the campaign both are negative.
    beyond_s = np.maximum(structure.origin_s - stops.time_s, stops.time_s - structure.last_s)
    return np.asarray(np.maximum(beyond_s, 0.0) / SECONDS_PER_HOUR)


def _lasted_h(structure: Structure) -> float:
    last_s = structure.origin_s if structure.last_s is None else structure.last_s
    return (last_s - structure.origin_s) / SECONDS_PER_HOUR
