"""The readings that an identification is judged by, and the table of figures that a reader compares."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.domain.identification import Identification, NominalAndIdentified
from truepose.identification import judge
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.error_tables import error_table, pair_rows
from truepose.reports.tables import Remarked, Table

# Held-out readings are never dropped. Figures "without" are for the reader's eye: a reading farther out
# than this many typical (median) errors tells of a blunder at the instrument, not of the model.
FAR_OUT = 5.0


def shown_noise_mm(identification: Identification) -> float:
    """Return the mean error that noise alone would show in the judged readings: that of their statistics."""
    pair = identification.validation or identification.calibration
    return 0.0 if pair is None else pair.identified.noise_mm


def judged(identification: Identification, campaign: Campaign) -> Assessment | None:
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


def without_far_out(judged: Assessment) -> tuple[NominalAndIdentified, int] | None:
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


def noise_split(judged: Assessment, residual_mm: FloatArray) -> NoiseSplit:
    """Split the root mean square of residuals, shape (n, d), in quadrature."""
    block = judged.block
    return NoiseSplit(
        measured_mm=float(np.sqrt((residual_mm**2).sum(axis=1).mean())),
        instrument_mm=float(np.sqrt(np.trace(block.covariance(), axis1=1, axis2=2).mean())),
        scatter_mm=float(np.sqrt(block.components) * block.scatter_mm),
    )


_REMARKS: Final = {
    "figures.validation": "figures.validation.remark",
    "figures.validation.near": "figures.validation.near.remark",
    "figures.cross_validation": "figures.cross_validation.remark",
    "figures.relative": "figures.relative.remark",
    "figures.positions": "figures.positions.remark",
    "figures.positions_aligned": "figures.positions_aligned.remark",
    "figures.calibration": "figures.calibration.remark",
    "figures.calibration.near": "figures.calibration.near.remark",
}


def figures_table(
    identification: Identification, words: Catalogue = IN_ENGLISH, shown: Assessment | None = None
) -> Table:
    """Return the statistics that a reader compares, with and without what lies far out."""
    rows = (
        row
        for key, values, pair in _figures(identification, shown)
        for row in pair_rows(Remarked(words.say(key), words.say(_REMARKS[key], **values)), pair, words)
    )
    return error_table(rows, words)


def _figures(
    identification: Identification, shown: Assessment | None
) -> Iterator[tuple[str, dict[str, float], NominalAndIdentified]]:
    """Yield the key of each kind of readings, what its remark is filled in with, and the figures."""
    if identification.validation is not None:
        yield "figures.validation", {}, identification.validation
        further = None if shown is None else without_far_out(shown)
        if further is not None:
            pair, dropped = further
            yield "figures.validation.near", {"dropped": dropped, "times": FAR_OUT}, pair
    elif identification.cross_validation is not None:
        yield "figures.cross_validation", {}, identification.cross_validation
    if identification.relative is not None:
        yield "figures.relative", {}, identification.relative
    positions = identification.positions  # of a model of lengths, where positions are held out
    if positions is not None and positions.tied is not None:
        yield "figures.positions", {}, positions.tied
    if positions is not None:
        yield "figures.positions_aligned", {}, positions.aligned
    if identification.calibration is not None:
        yield "figures.calibration", {}, identification.calibration
    if identification.calibration_without_outliers is not None:
        without, outliers = identification.calibration_without_outliers, identification.counts.outliers
        yield "figures.calibration.near", {"outliers": outliers}, without
