"""How exactly an instrument reads positions."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray

_M_PER_MM = 1e-3


@dataclass(frozen=True, slots=True)
class TrackerAccuracy:
    """Standard deviations of one reading, along the beam and across it; typical of laser trackers.

    The thesis found 0.022 mm on a bar of 2.3 m at 2 m (A. Nubiola, 2014, section 2.2), which is two readings.
    """

    along_mm: float = 0.008
    along_mm_per_m: float = 0.0008
    across_mm: float = 0.010
    across_mm_per_m: float = 0.0035

    def covariance_mm2(self, beam_mm: FloatArray) -> FloatArray:
        """Return the covariance of one reading at the end of each beam (n, 3), shape (n, 3, 3).

        Where a beam is NaN nobody knows whence it comes: the same along all axes, at no distance.
        """
        distance = np.linalg.norm(beam_mm, axis=1)
        known = np.isfinite(distance)
        metres = np.where(known, distance, 0.0)[:, None, None] * _M_PER_MM
        along = (self.along_mm + self.along_mm_per_m * metres) ** 2
        across = (self.across_mm + self.across_mm_per_m * metres) ** 2
        way = beam_mm[known] / distance[known, None]
        projector = np.broadcast_to(np.eye(3) / 3.0, (len(beam_mm), 3, 3)).copy()
        projector[known] = way[:, :, None] * way[:, None, :]
        return np.asarray(along * projector + across * (np.eye(3) - projector))


TYPICAL: Final = TrackerAccuracy()


def stated(per_axis_mm: float) -> TrackerAccuracy:
    """Return the accuracy of an instrument that reads equally well everywhere, along every axis."""
    return TrackerAccuracy(per_axis_mm, 0.0, per_axis_mm, 0.0)
