"""Relative accuracy: what is left of position errors once the base may stand anywhere.

An absolute figure counts where the model believes the robot to stand, a relative one does not (thesis of
A. Nubiola, 2014, section 1.1): whoever sets up a work object by the robot itself sees the relative one.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results import NominalAndIdentified
from truepose.identification.verdict.judge import Judged
from truepose.identification.verdict.statistics import expected_noise_mm, statistics
from truepose.kinematics.frames import rigid_alignment

_FEWEST: Final = 4  # three places on a plane are aligned to almost nothing


def relative_errors(judged: Judged) -> NominalAndIdentified | None:
    """Return the statistics after the best rigid alignment; None of lengths, or of too few readings."""
    places = judged.block.place_mm
    if places is None or len(places) < _FEWEST or _on_a_line(places):
        return None
    noise = expected_noise_mm(judged.block)
    nominal, identified = judged.nominal.state.position_mm, judged.position_mm
    return NominalAndIdentified(
        statistics(_aligned(nominal, places), noise), statistics(_aligned(identified, places), noise)
    )


def _aligned(predicted_mm: FloatArray, places_mm: FloatArray) -> FloatArray:
    rotation, translation = rigid_alignment(predicted_mm, places_mm)
    return np.asarray(places_mm - (predicted_mm @ rotation.T + translation))


def _on_a_line(places_mm: FloatArray) -> bool:
    widths = np.linalg.svd(places_mm - places_mm.mean(axis=0), compute_uv=False)
    return bool(widths[1] < 1e-3 * max(widths[0], 1e-12))
