"""What residuals over joint angles show.

Each joint, direction and order is fitted alone by least squares. A wave cos(k q), sin(k q) has two degrees of
freedom; whether it is more than noise is told by the F distribution with 2 and m degrees of freedom, whose
tail is (1 + 2 F / m)^(-m/2) (Abramowitz and Stegun, 26.6.4). As many waves as are tried, so much smaller must
the chance be (Bonferroni).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.sentences import Sentence, said

_ORDERS: Final = (1, 2, 3, 4)  # waves per turn; gears' own cycles are the diagnosis' business
_LEAST_PART: Final = 0.6  # of a wave's period that the joint must have covered
_CHANCE: Final = 1e-3  # of a sentence where there is only noise
_FEWEST: Final = 12  # readings
_RMS: Final = 2.0**0.5  # amplitude of a wave over its root mean square


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave of one joint."""

    joint: int  # from 1
    order: int
    amplitude_mm: float
    chance: float  # that noise alone explains as much


def joints_sentence(joints_rad: FloatArray, residual_mm: FloatArray, model_u_mm: float = 0.0) -> Sentence:
    """Return the largest wave that is more than noise, and how many joints have one.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
    residual_mm : ndarray, shape (J, n, d)
        As each joint sees it, `residuals_by_joint`.
    model_u_mm : float
        Standard uncertainty of the model's own predictions, per axis: what its parameters miss is smooth over
        the joints, and no finding.
    """
    tried = list(_waves(joints_rad, residual_mm))
    known = [wave for wave in tried if wave.amplitude_mm > _RMS * model_u_mm]
    found = [wave for wave in known if wave.chance * len(tried) < _CHANCE]
    if not found:
        return said("seen.joints.nothing")
    largest = max(found, key=lambda wave: wave.amplitude_mm)
    others = len({wave.joint for wave in found}) - 1
    key = "seen.joints.wave" if not others else "seen.joints.waves"
    return said(
        key,
        joint=f"joint {largest.joint}",
        order=largest.order,
        peak_mm=2.0 * largest.amplitude_mm,
        others=others,
    )


def _waves(joints_rad: FloatArray, residual_mm: FloatArray) -> Iterator[Wave]:
    n = len(joints_rad)
    if n < _FEWEST:
        return
    for joint, (angle, residual) in enumerate(zip(joints_rad.T, residual_mm, strict=True), start=1):
        for order in _ORDERS:
            if np.ptp(angle) * order >= _LEAST_PART * 2.0 * np.pi:
                for component in residual.T:
                    yield _wave(joint, order, angle, component)


def _wave(joint: int, order: int, angle: FloatArray, residual: FloatArray) -> Wave:
    """Fit mean and wave; the mean alone is what it is held against."""
    rows = np.column_stack([np.cos(order * angle), np.sin(order * angle)])
    rows, residual = rows - rows.mean(axis=0), residual - residual.mean()
    coefficients, *_ = np.linalg.lstsq(rows, residual, rcond=None)
    total, left = float(residual @ residual), float(((residual - rows @ coefficients) ** 2).sum())
    freedom = len(residual) - 3
    ratio = left / total if total > 0.0 else 1.0  # (1 + 2 F / m)^-1
    return Wave(joint, order, float(np.hypot(*coefficients)), ratio ** (freedom / 2.0))
