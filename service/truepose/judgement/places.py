"""Errors by place: how far from where the model was made, how far from axis 1, in which posture."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import MeasuredZone, Model
from truepose.domain.results.validation import BranchErrors, ErrorsByPlace, Shell
from truepose.identification.model.validity.zone import DIRECTIONS
from truepose.identification.verdict.judge import Judged
from truepose.kinematics.chain import Chain
from truepose.kinematics.inverse import BRANCH_NAMES, branch_of, has_closed_form

_SHELLS: Final = 8  # at most


def errors_by_place(model: Model, judged: Judged) -> ErrorsByPlace:
    """Return the errors before and after by place of the last frame and by posture of the arm.

    Parameters
    ----------
    model : Model
        Says where the readings lay that it was made from.
    judged : Judged
        The model against n >= 1 other readings.

    Returns
    -------
    ErrorsByPlace
        From the middle of these readings where the model does not say where its own lay; without postures
        where the arm has no closed inverse, since its branches have no names then.
    """
    chain = judged.identified.state.chain
    centre, radius = _of_readings(chain) if model.zone is None else _of_zone(model.zone, chain)
    x, y, z = (float(value) for value in centre)
    return ErrorsByPlace(
        (x, y, z),
        radius,
        zone_stated=model.zone is not None,
        from_zone=_shells(judged, np.linalg.norm(chain.end_origin - centre, axis=1)),
        from_axis=_shells(judged, distance_from_axis_1(chain)),
        branches=tuple(_branches(judged)),
    )


def _of_readings(chain: Chain) -> tuple[FloatArray, float]:
    centre = chain.end_origin.mean(axis=0)
    return centre, float(np.linalg.norm(chain.end_origin - centre, axis=1).max())


def _of_zone(zone: MeasuredZone, chain: Chain) -> tuple[FloatArray, float]:
    """Return the middle of the box around a zone, in the world, and how far its farthest face is from it."""
    extents = np.array(zone.extents_mm)
    ends = [[extents[np.argmax(DIRECTIONS @ (side * axis))] for side in (1.0, -1.0)] for axis in np.eye(3)]
    middle = np.array([0.5 * (ahead - behind) for ahead, behind in ends])
    centre = chain.base_rotation[0] @ middle + chain.base_origin[0]
    return np.asarray(centre), float((extents - DIRECTIONS @ middle).max())


def distance_from_axis_1(chain: Chain) -> FloatArray:
    """Return how far each last frame lies from the line of axis 1 [mm], shape (n,)."""
    away, axis = chain.end_origin - chain.origin[0], chain.z[0]
    along = np.sum(away * axis, axis=1, keepdims=True)
    return np.asarray(np.linalg.norm(away - along * axis, axis=1))


def _shells(judged: Judged, distance_mm: FloatArray) -> tuple[Shell, ...]:
    width = _width_mm(float(np.ptp(distance_mm)))
    number = np.floor(distance_mm / width).astype(np.int64)
    return tuple(
        Shell(float(k * width), float((k + 1) * width), judged.pair(number == k)) for k in np.unique(number)
    )


def _width_mm(range_mm: float) -> float:
    """Return a width of 1, 2 or 5 times a power of ten that cuts the range into few shells."""
    least = max(range_mm, 1.0) / (_SHELLS - 1)  # one more is needed where the range begins within a shell
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least))


def _branches(judged: Judged) -> Iterator[BranchErrors]:
    robot = judged.identified.state.structure.robot
    if not has_closed_form(robot):
        return
    posture = branch_of(robot, judged.stops.joints_rad)
    for number in np.unique(posture):
        yield BranchErrors(BRANCH_NAMES[number], judged.pair(posture == number))
