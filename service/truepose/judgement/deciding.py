"""What makes up the uncertainty of the reading that decides about a limit, or of the largest error."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.identification.verdict.judge import Judged
from truepose.judgement.uncertainty import Known


@dataclass(frozen=True, slots=True)
class DecidingReading:
    """An error, and its standard uncertainties along it [mm]."""

    config: int
    error_mm: float
    reading_u_mm: float  # of where the place was read
    placement_u_mm: float  # of where the model believes the robot to stand

    @property
    def combined_u_mm(self) -> float:
        """Both together: what the guard band is a multiple of."""
        return float(np.hypot(self.reading_u_mm, self.placement_u_mm))


def deciding_reading(judged: Judged, known: Known, error_mm: float | None = None) -> DecidingReading:
    """Return the reading whose error a decision names; without one, that of the largest error.

    Parameters
    ----------
    judged : Judged
        n >= 1 readings.
    known : Known
        Of the same readings.
    error_mm : float, optional
        Size of the error that decides.
    """
    sizes = np.linalg.norm(judged.identified_mm, axis=1)
    row = int(np.argmax(sizes) if error_mm is None else np.argmin(np.abs(sizes - error_mm)))
    own, whole = known.covariance[row], known.of_single()[row]
    along = _along(judged.identified_mm[row], whole)
    reading, shared = float(along @ own @ along), float(along @ (whole - own) @ along)
    return DecidingReading(
        int(judged.stops.config[row]),
        float(sizes[row]),
        float(np.sqrt(max(reading, 0.0))),
        float(np.sqrt(max(shared, 0.0))),
    )


def _along(error_mm: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the direction of an error; of none, the worst known one."""
    size = float(np.linalg.norm(error_mm))
    return error_mm / size if size > 0.0 else np.asarray(np.linalg.eigh(covariance)[1][:, -1])
