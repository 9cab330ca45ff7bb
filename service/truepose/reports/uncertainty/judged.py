"""The readings that a report judges the model by, with their residuals before and after."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, LegReadings, PointReadings, Stops
from truepose.domain.results import Identification, Model, NominalAndIdentified
from truepose.identification import predict, predict_lengths, predict_nominal
from truepose.identification.verdict.statistics import mean_norm, statistics

# Held-out readings are never dropped. Figures "without" are for the reader's eye: a reading farther out
# than this many typical (median) errors tells of a blunder at the instrument, not of the model.
FAR_OUT = 5.0


@dataclass(frozen=True, slots=True)
class Judged:
    """n readings of d components: 3 of a position, 1 of a length."""

    readings: PointReadings | LegReadings
    held_out: bool  # False: the readings that the model was made from
    nominal_mm: FloatArray  # (n, d) residuals: observed minus predicted
    identified_mm: FloatArray  # (n, d)
    covariance_mm2: FloatArray  # (n, d, d) of the readings as stated
    scatter_mm: float  # of the arm, per component; 0 where the stated uncertainty contains it
    position_mm: FloatArray  # (n, 3) of the nests as predicted, world frame
    direction: FloatArray | None = None  # (n, 3) of the legs, from base nest to tool nest

    @property
    def stops(self) -> Stops:
        """Where the arm stood."""
        return self.readings.stops

    def vectors_mm(self, residual_mm: FloatArray) -> FloatArray:
        """Return residuals as vectors in the world, shape (n, 3): those of legs lie along the leg."""
        return residual_mm if self.direction is None else residual_mm * self.direction


def judging_figures(identification: Identification) -> NominalAndIdentified | None:
    """Return the figures that judge the model: validation, else cross-validation, else calibration."""
    return identification.validation or identification.cross_validation or identification.calibration


def shown_noise_mm(identification: Identification, judged: Judged) -> float:
    """Return the mean error that noise alone would show in the judged readings: that of their statistics."""
    pair = identification.validation if judged.held_out else identification.calibration
    return 0.0 if pair is None else pair.identified.noise_mm


def judged(identification: Identification, campaign: Campaign) -> Judged | None:
    """Return the held-out readings, else those of the calibration; None without a model.

    Raises
    ------
    ConfigurationError
        The campaign does not fit the model of the identification.
    """
    model = identification.model
    if model is None:
        return None
    points, legs = (campaign.calibration, campaign.validation), (campaign.legs, campaign.validation_legs)
    made_from, held_out = points if identification.quantity == "position" else legs
    readings = held_out if held_out is not None and len(held_out) else made_from
    if readings is None:
        return None
    scatter = 0.0 if campaign.repeatability_in_uncertainty else campaign.robot.repeatability_mm
    return judged_by(model, readings, held_out=readings is held_out, scatter_mm=scatter)


def judged_by(
    model: Model, readings: PointReadings | LegReadings, *, held_out: bool, scatter_mm: float
) -> Judged:
    """Return readings with their residuals; raises ConfigurationError where they do not fit the model."""
    if isinstance(readings, PointReadings):
        return _points(model, readings, held_out, scatter_mm)
    return _legs(model, readings, held_out, scatter_mm)


def _points(model: Model, points: PointReadings, held_out: bool, scatter_mm: float) -> Judged:
    predicted, _ = predict(model, points.stops, points.nest)
    covariance = points.covariance_mm2
    if covariance is None:
        covariance = points.standard_uncertainty_mm[:, None, None] ** 2 * np.eye(3)
    return Judged(
        readings=points,
        held_out=held_out,
        nominal_mm=points.position_mm - predict_nominal(model, points.stops, points.nest),
        identified_mm=points.position_mm - predicted,
        covariance_mm2=covariance,
        scatter_mm=scatter_mm,
        position_mm=predicted,
    )


def _legs(model: Model, legs: LegReadings, held_out: bool, scatter_mm: float) -> Judged:
    predicted, _ = predict(model, legs.stops, legs.nest)
    lengths = predict_lengths(model, legs)  # refuses base nests that the model does not know
    # The nominal fit's base nests are within millimetres of the identified ones: enough for a direction.
    places = {(anchor.placement, anchor.base_point): anchor.centre_mm for anchor in model.nominal_anchors}
    feet = np.array([
        places[key] for key in zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True)
    ])
    along = predicted - feet
    return Judged(
        readings=legs,
        held_out=held_out,
        nominal_mm=(legs.length_mm - predict_lengths(model, legs, nominal=True))[:, None],
        identified_mm=(legs.length_mm - lengths)[:, None],
        covariance_mm2=legs.standard_uncertainty_mm[:, None, None] ** 2,
        scatter_mm=scatter_mm,
        position_mm=predicted,
        direction=along / np.linalg.norm(along, axis=1, keepdims=True),
    )


def without_far_out(judged: Judged) -> tuple[NominalAndIdentified, int] | None:
    """Return the statistics without readings beyond `FAR_OUT` typical errors and their number, if any."""
    norms = np.linalg.norm(judged.identified_mm, axis=1)
    kept = norms <= FAR_OUT * float(np.median(norms))
    dropped = int((~kept).sum())
    if dropped == 0:
        return None
    components = judged.covariance_mm2.shape[-1]
    noise = _mean_norm(judged.covariance_mm2[kept] + judged.scatter_mm**2 * np.eye(components))
    pair = NominalAndIdentified(
        statistics(judged.nominal_mm[kept], noise), statistics(judged.identified_mm[kept], noise)
    )
    return pair, dropped


def _mean_norm(covariance_mm2: FloatArray) -> float:
    if covariance_mm2.shape[-1] == 3:
        return mean_norm(covariance_mm2)
    return float(np.sqrt(2.0 / np.pi) * np.sqrt(covariance_mm2[:, 0, 0]).mean())


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
    components = residual_mm.shape[1]
    return NoiseSplit(
        measured_mm=float(np.sqrt((residual_mm**2).sum(axis=1).mean())),
        instrument_mm=float(np.sqrt(np.trace(judged.covariance_mm2, axis1=1, axis2=2).mean())),
        scatter_mm=float(np.sqrt(components) * judged.scatter_mm),
    )
