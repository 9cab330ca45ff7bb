"""An identified model against the truth of the simulated cell.

True error: noise-free position of the nest minus the model's prediction, both in the world frame. It
contains what the tracker's registration in the world is off by; after the best rigid alignment it does not.

True value of a parameter: what an identification with the same parametrisation gives on noise-free,
scatter-free readings of the same configurations, with the nests held at their true places. The plant has
rigid motions where the model has DH-Modified rows, so no table of the simulator holds that number.
"""

import math
from dataclasses import dataclass, replace

from truepose.demo.cell_run import CellRun
from truepose.demo.truth import TrueReadings
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.identification import Identification, Model, Parameter, Statistics
from truepose.domain.robot import Nest
from truepose.exchange.models.document import file_factor, file_unit
from truepose.identification import identify, predict
from truepose.identification.verdict.judge import statistics
from truepose.kinematics.frames import rigid_alignment
from truepose.reports.identification.summary import TrueParameter


@dataclass(frozen=True, slots=True)
class TrueErrors:
    """Statistics of the true errors of a model at the validation configurations."""

    absolute: Statistics
    aligned: Statistics  # after the best rigid alignment


@dataclass(frozen=True, slots=True)
class JudgedRun:
    """A run and everything that the truth says of its model; nothing where it has none."""

    run: CellRun
    identification: Identification  # the service's, with what its document does not carry
    errors: TrueErrors | None
    parameters: tuple[TrueParameter, ...]


def judge(run: CellRun) -> JudgedRun:
    """Return the run beside its truth."""
    # The same campaign by the same code gives the same numbers: the document is not the place for a model.
    identification = identify(run.campaign, tuple(run.identification["effects"]))
    if run.model is None or run.campaign.validation is None:
        return JudgedRun(run, identification, None, ())
    return JudgedRun(
        run=run,
        identification=identification,
        errors=true_errors(run.model, run.true.judged or run.campaign.validation, run.true.validation_mm),
        parameters=parameters_against_truth(run.model, run.campaign, run.true),
    )


def true_errors(model: Model, readings: PointReadings, true_mm: FloatArray) -> TrueErrors:
    """Return how far the model is from the truth.

    Parameters
    ----------
    model : Model
    readings : PointReadings
        n readings; only their stops and nests are used.
    true_mm : ndarray, shape (n, 3)
        Where the nests truly were.
    """
    predicted, _ = predict(model, readings.stops, readings.nest)
    # Neither side has reading noise, so the stated uncertainties let no error be expected.
    absolute = statistics(true_mm - predicted, 0.0)
    return TrueErrors(absolute, statistics(true_mm - rigidly_aligned(predicted, true_mm), 0.0))


def rigidly_aligned(points_mm: FloatArray, onto_mm: FloatArray) -> FloatArray:
    """Return the points after the rigid motion that brings them closest to others, shape (n, 3)."""
    rotation, translation = rigid_alignment(points_mm, onto_mm)
    aligned: FloatArray = points_mm @ rotation.T + translation
    return aligned


def parameters_against_truth(
    model: Model, campaign: Campaign, true: TrueReadings
) -> tuple[TrueParameter, ...]:
    """Return every parameter of the model beside its true value, NaN where the truth identifies none."""
    reference = identify(true_campaign(campaign, true), model.effects).model
    values = {} if reference is None else {p.name: p.value for p in reference.parameters}
    return tuple(_compared(parameter, values.get(parameter.name, math.nan)) for parameter in model.parameters)


def true_campaign(campaign: Campaign, true: TrueReadings) -> Campaign:
    """Return the campaign as instruments and arm without noise and scatter would have measured it."""
    if campaign.calibration is None:
        return campaign
    nests = tuple(
        Nest((float(x), float(y), float(z)), nest.standard_uncertainty_mm, nest.facing)
        for nest, (x, y, z) in zip(campaign.nests, true.tool_nests_mm, strict=True)
    )
    turns = campaign.calibration.quaternion
    if true.calibration_quaternion is not None:
        turns = true.calibration_quaternion
    readings = replace(campaign.calibration, position_mm=true.calibration_mm, quaternion=turns)
    return replace(campaign, nests=nests, calibration=readings, validation=None)


def _compared(parameter: Parameter, true: float) -> TrueParameter:
    factor = file_factor(parameter.unit)
    return TrueParameter(
        name=parameter.name,
        identified=parameter.value * factor,
        true=true * factor,
        standard_uncertainty=parameter.standard_uncertainty * factor,
        unit=file_unit(parameter.unit),
    )
