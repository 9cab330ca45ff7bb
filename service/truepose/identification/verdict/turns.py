"""Orientations that were read against those of a model: what positions alone do not show."""

import math
from typing import TYPE_CHECKING

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import PointReadings, Readings
from truepose.domain.results.identification import Model, TurnPair, TurnStatistics
from truepose.identification.model.estimates import Estimate, identified_estimate, nominal_estimate
from truepose.identification.verdict.statistics import mean_norm

if TYPE_CHECKING:
    from truepose.identification.observations.orientations import OrientationBlock

_OF_THE_TOOL = "tool_rx"


def turn_errors(model: Model, readings: Readings | None) -> TurnPair | None:
    """Return the angles between measured orientations and those of a model.

    None where none were read, and of a model that was made without: it does not know how the frame of the
    readings is turned against the last one.
    """
    if not isinstance(readings, PointReadings) or _OF_THE_TOOL not in {p.name for p in model.parameters}:
        return None
    from truepose.identification.observations.orientations import orientation_block  # few read them

    block = orientation_block(readings)
    if block is None:
        return None
    nominal, identified = (_turns(block, one(model)) for one in (nominal_estimate, identified_estimate))
    return TurnPair(nominal, identified)


def _turns(block: "OrientationBlock", model: Estimate) -> TurnStatistics:
    angles: FloatArray = np.linalg.norm(block.result(model.structure, model.values, None).residual, axis=1)
    return TurnStatistics(
        n=len(angles),
        mean_rad=float(angles.mean()),
        rms_rad=float(np.sqrt((angles**2).mean())),
        sd_rad=float(angles.std(ddof=1)) if len(angles) > 1 else 0.0,
        max_rad=float(angles.max()),
        noise_rad=mean_norm(block.covariance()) if block.stated_sigma() > 0.0 else math.nan,
    )
