"""Errors of a model where the tool stood, and the arm at those that say most."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Readings
from truepose.domain.identification import Model
from truepose.identification.verdict.judge import judge
from truepose.reports.figures.error_maps import exaggeration
from truepose.reports.plan_3d import arm_pieces

_MOST_ARROWS: Final = 600  # more hide each other
_MOST_POSES: Final = 24


@dataclass(frozen=True, slots=True)
class Pose:
    """The arm in one configuration, and how far off its readings were there."""

    config: int
    pieces_mm: FloatArray  # (m, 7) start, end and radius in the world
    before_mm: float  # largest error of its readings
    after_mm: float


@dataclass(frozen=True, slots=True)
class ErrorSpace:
    """Readings in space against the nominal robot and the identified model."""

    robot: str
    points_mm: FloatArray  # (n, 3) where the tool stood, world
    before_mm: FloatArray  # (n, 3) seen minus foreseen by the nominal robot
    after_mm: FloatArray  # (n, 3) by the identified model
    times_before: float  # by which the vectors are best shown longer than they are
    times_after: float
    poses: tuple[Pose, ...]  # the worst of the identified model first
    instrument_mm: tuple[float, float, float] | None
    total: int  # readings, of which an even selection is shown


def error_space(model: Model, readings: Readings, config: int | None = None) -> ErrorSpace:
    """Return the errors of a model at readings, with the arm where they are largest.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings
    config : int, optional
        A configuration whose arm comes first, however small its errors are.

    Raises
    ------
    ConfigurationError
        The readings do not fit the model.
    """
    judged = judge(model, readings, model.repeatability_mm)
    points = judged.position_mm
    before, after = judged.vectors_mm(judged.nominal_mm), judged.vectors_mm(judged.identified_mm)
    shown = slice(None, None, -(-len(points) // _MOST_ARROWS))
    return ErrorSpace(
        robot=model.robot.name,
        points_mm=points[shown],
        before_mm=before[shown],
        after_mm=after[shown],
        times_before=exaggeration(points, before),
        times_after=exaggeration(points, after),
        poses=_poses(model, readings, _norms(before), _norms(after), config),
        instrument_mm=model.instrument_mm,
        total=len(points),
    )


def _poses(
    model: Model, readings: Readings, before_mm: FloatArray, after_mm: FloatArray, first_config: int | None
) -> tuple[Pose, ...]:
    configs, first, row_of = np.unique(readings.stops.config, return_index=True, return_inverse=True)
    worst_before, worst_after = (_largest(each, row_of, len(configs)) for each in (before_mm, after_mm))
    chosen = np.lexsort((-worst_after, configs != first_config))[:_MOST_POSES]
    nests = np.array([nest.centre_mm for nest in model.nests]).reshape(-1, 3)
    pieces = arm_pieces(model.robot, model.base, nests, readings.stops.joints_rad[first[chosen]])
    return tuple(
        Pose(int(configs[k]), arm, float(worst_before[k]), float(worst_after[k]))
        for k, arm in zip(chosen, pieces, strict=True)
    )


def _largest(values: FloatArray, row_of: IntArray, n: int) -> FloatArray:
    found = np.zeros(n)
    np.maximum.at(found, row_of.reshape(-1), values)
    return found


def _norms(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(vectors, axis=1))
