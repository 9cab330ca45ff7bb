"""The readings that a report judges the model by, with their residuals before and after."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.results.identification import Identification, NominalAndIdentified
from truepose.identification import judge
from truepose.identification.verdict.judge import Judged

# Held-out readings are never dropped. Figures "without" are for the reader's eye: a reading farther out
# than this many typical (median) errors tells of a blunder at the instrument, not of the model.
FAR_OUT = 5.0


def judging_figures(identification: Identification) -> NominalAndIdentified | None:
    """Return the figures that judge the model: validation, else cross-validation, else calibration."""
    return identification.validation or identification.cross_validation or identification.calibration


def shown_noise_mm(identification: Identification) -> float:
    """Return the mean error that noise alone would show in the judged readings: that of their statistics."""
    pair = identification.validation or identification.calibration
    return 0.0 if pair is None else pair.identified.noise_mm


def judged(identification: Identification, campaign: Campaign) -> Judged | None:
    """Return the held-out readings, else those of the calibration; None without a model.

    Raises
    ------
    ConfigurationError
        The campaign does not fit the model of the identification.
    """
    readings = campaign.held_out or campaign.readings
    if identification.model is None or readings is None:
        return None
    return judge(identification.model, readings, campaign.scatter_mm)


def without_far_out(judged: Judged) -> tuple[NominalAndIdentified, int] | None:
    """Return the statistics without readings beyond `FAR_OUT` typical errors and their number, if any."""
    norms = np.linalg.norm(judged.identified_mm, axis=1)
    kept = norms <= FAR_OUT * float(np.median(norms))
    dropped = int((~kept).sum())
    return (judged.pair(kept), dropped) if dropped else None


@dataclass(frozen=True, slots=True)
class NoiseSplit:
    """Measured RMS as a sum of squares: what is not instrument or scatter is the model's."""

    measured_mm: float
    instrument_mm: float
    scatter_mm: float

    @property
    def model_mm(self) -> float | None:
        """What is left for the model; None where noise alone explains more than was measured."""
        left = self.measured_mm**2 - self.instrument_mm**2 - self.scatter_mm**2
        return float(np.sqrt(left)) if left > 0.0 else None

    @property
    def instrument_share(self) -> float:
        """Share of the mean square that is the instrument's own."""
        return self.instrument_mm**2 / self.measured_mm**2 if self.measured_mm > 0.0 else 0.0


def noise_split(judged: Judged, residual_mm: FloatArray) -> NoiseSplit:
    """Split the root mean square of residuals, shape (n, d), in quadrature."""
    block = judged.block
    return NoiseSplit(
        measured_mm=float(np.sqrt((residual_mm**2).sum(axis=1).mean())),
        instrument_mm=float(np.sqrt(np.trace(block.covariance(), axis1=1, axis2=2).mean())),
        scatter_mm=float(np.sqrt(block.components) * block.scatter_mm),
    )
