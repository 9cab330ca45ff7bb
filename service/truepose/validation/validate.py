"""A model judged by readings that it was not made from: whether it keeps what it claims, and where.

The decision is that of ISO 14253-1:2017, with the uncertainty of measuring counted: conformity is proved
where the value stays within the limit by more than the guard band, nonconformity where it lies beyond the
limit by more than that; in between nothing is proved. The guard band is 1.65 standard uncertainties: 95 % of
a normal distribution, one-sided.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Readings
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import MeasuredZone, Model, NominalAndIdentified
from truepose.domain.validation import (
    BranchErrors,
    Decision,
    DecisionRule,
    DistanceBin,
    ErrorsByPlace,
    Validation,
    Verdict,
)
from truepose.identification import judge
from truepose.identification.model.validity import DIRECTIONS
from truepose.identification.verdict.judge import Assessment
from truepose.identification.verdict.relative_accuracy import relative_errors, turn_errors
from truepose.kinematics.chain import Chain
from truepose.kinematics.inverse import BRANCH_NAMES, branch_of, has_closed_form
from truepose.validation.distance_errors import distances
from truepose.validation.uncertainty import (
    PICOMETRES,
    Figure,
    Uncertainties,
    figure_uncertainty,
    known,
)

_SHELLS: Final = 8  # at most


def errors_by_place(model: Model, judged: Assessment) -> ErrorsByPlace:
    """Return the errors before and after by place of the flange frame and by posture of the arm.

    Parameters
    ----------
    model : Model
        Says where the readings lay that it was made from.
    judged : Assessment
        The model against n >= 1 other readings.

    Returns
    -------
    ErrorsByPlace
        From the middle of these readings where the model does not say where its own lay; without postures
        where the arm has no closed inverse, since its branches have no names then.
    """
    chain = judged.identified.state.chain
    centre, radius = _of_readings(chain) if model.zone is None else _of_zone(model.zone, chain)
    x, y, z = (float(value) for value in centre)
    return ErrorsByPlace(
        (x, y, z),
        radius,
        zone_stated=model.zone is not None,
        from_zone=_shells(judged, np.linalg.norm(chain.end_origin - centre, axis=1)),
        from_axis=_shells(judged, distance_from_axis_1(chain)),
        branches=tuple(_branches(judged)),
    )


def _of_readings(chain: Chain) -> tuple[FloatArray, float]:
    """Return the middle of the flange frames (3,), and how far the farthest is from it [mm]."""
    centre = chain.end_origin.mean(axis=0)
    return centre, float(np.linalg.norm(chain.end_origin - centre, axis=1).max())


def _of_zone(zone: MeasuredZone, chain: Chain) -> tuple[FloatArray, float]:
    """Return the middle of the box around a zone, in the world, and how far its farthest face is from it."""
    extents = np.array(zone.extents_mm)
    ends = [[extents[np.argmax(DIRECTIONS @ (side * axis))] for side in (1.0, -1.0)] for axis in np.eye(3)]
    middle = np.array([0.5 * (ahead - behind) for ahead, behind in ends])
    centre = chain.base_rotation[0] @ middle + chain.base_origin[0]
    return np.asarray(centre), float((extents - DIRECTIONS @ middle).max())


def distance_from_axis_1(chain: Chain) -> FloatArray:
    """Return how far each flange frame lies from the line of axis 1.

    Parameters
    ----------
    chain : Chain
        At n configurations.

    Returns
    -------
    ndarray, shape (n,)
        [mm].
    """
    away, axis = chain.end_origin - chain.origin[0], chain.z[0]
    along = np.sum(away * axis, axis=1, keepdims=True)
    return np.asarray(np.linalg.norm(away - along * axis, axis=1))


def _shells(judged: Assessment, distance_mm: FloatArray) -> tuple[DistanceBin, ...]:
    """Return the errors in shells of equal width by distance (n,) [mm]; empty ones are left out."""
    width = _width_mm(float(np.ptp(distance_mm)))
    number = np.floor(distance_mm / width).astype(np.int64)
    return tuple(
        DistanceBin(float(k * width), float((k + 1) * width), judged.pair(number == k))
        for k in np.unique(number)
    )


def _width_mm(range_mm: float) -> float:
    """Return a width of 1, 2 or 5 times a power of ten that cuts the range into few shells."""
    least = max(range_mm, 1.0) / (_SHELLS - 1)  # one more is needed where the range begins within a shell
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least))


def _branches(judged: Assessment) -> Iterator[BranchErrors]:
    """Yield the errors of each posture that occurs."""
    robot = judged.identified.state.structure.robot
    if not has_closed_form(robot):
        return
    posture = branch_of(robot, judged.stops.joints_rad)
    for number in np.unique(posture):
        yield BranchErrors(BRANCH_NAMES[number], judged.pair(posture == number))


# ISO 14253-1:2017 lets 5 % of one side be wrong; a reading that decides is beyond the limit on one side only.
_COVERAGE: Final = 1.65


def decide(judged: Assessment, known: Uncertainties, limit_mm: float, rule: DecisionRule) -> Decision:
    """Decide whether all errors of the identified model stay within a limit.

    Parameters
    ----------
    judged : Assessment
        n >= 1 readings.
    known : Uncertainties
        What counts of their uncertainty: the instrument's, and that of where the robot stands. Scatter of
        the arm and errors of the model are what is judged.
    limit_mm : float
    rule : DecisionRule
        `simple` leaves the uncertainty out, so that something is always decided.

    Returns
    -------
    Decision
        With the guard band of the reading that decides.

    References
    ----------
    ISO 14253-1:2017.
    """
    errors = np.linalg.norm(judged.identified_mm, axis=1)
    guard = np.zeros_like(errors) if rule == "simple" else _COVERAGE * _uncertainty_mm(judged, known, errors)
    return _decision(errors, guard, limit_mm, rule)


def decide_figures(figures: Sequence[Figure], limit_mm: float, rule: DecisionRule) -> Decision:
    """Decide whether all of n >= 1 figures stay within a limit, whatever their sign.

    Parameters
    ----------
    figures : sequence of Figure
    limit_mm : float
    rule : DecisionRule
        As of `decide`.

    Returns
    -------
    Decision
    """
    sizes = np.array([abs(one.value) for one in figures])
    u = np.array([one.standard_uncertainty for one in figures])
    return _decision(sizes, np.zeros_like(u) if rule == "simple" else _COVERAGE * u, limit_mm, rule)


def _decision(errors: FloatArray, guard: FloatArray, limit_mm: float, rule: DecisionRule) -> Decision:
    """Return the decision about errors with their guard bands, (n,) each [mm]."""
    beyond, within = errors - guard, errors + guard
    # One proved error is enough, however many readings are undecided; conformity needs all of them.
    if beyond.max() > limit_mm:
        return _decided("does not conform", beyond, errors, guard, limit_mm, rule)
    verdict: Verdict = "conforms" if within.max() <= limit_mm else "cannot be decided"
    return _decided(verdict, within, errors, guard, limit_mm, rule)


def _decided(
    verdict: Verdict,
    deciding: FloatArray,
    errors: FloatArray,
    guard: FloatArray,
    limit_mm: float,
    rule: DecisionRule,
) -> Decision:
    """Return a decision by the worst reading in this sense; a small error that is badly known may be."""
    row = int(np.argmax(deciding))
    return Decision(rule, limit_mm, float(errors[row]), float(guard[row]), verdict)


def _uncertainty_mm(judged: Assessment, known: Uncertainties, errors_mm: FloatArray) -> FloatArray:
    """Return the standard uncertainty along each error; of no error, along the worst way."""
    covariance = known.of_single()
    unit = judged.identified_mm / np.where(errors_mm > 0.0, errors_mm, 1.0)[:, None]
    along = np.einsum("ni,nij,nj->n", unit, covariance, unit)
    own = np.where(errors_mm > 0.0, along, np.linalg.eigvalsh(covariance)[:, -1])
    return np.asarray(np.round(np.sqrt(np.maximum(own, 0.0)), PICOMETRES))


_BEYOND_CLAIM = 3.0  # times the claimed mean error: drift and other zones of the work space stay within it


def validate(
    model: Model, readings: Readings, *, limit_mm: float | None = None, rule: DecisionRule = "guard band"
) -> Validation:
    """Judge a model on readings it was not made from.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings
        n >= 1 readings.
    limit_mm : float, optional
        Largest error that passes; without it the model passes when its mean error is neither above the
        nominal model's nor far above what it claims itself.
    rule : DecisionRule
        How the decision about the limit counts the uncertainty of the readings; whether the model passes
        does not depend on it.

    Returns
    -------
    Validation

    Raises
    ------
    ConfigurationError
        The readings do not fit the model, or there are none.
    """
    if len(readings) == 0:
        raise ConfigurationError("There are no readings to validate with.")
    found = judge(model, readings, model.repeatability_mm)
    pair, claimed = found.pair(), found.claimed_mm()
    passed = _passes(pair, limit_mm, claimed)
    apart, relative = distances(found), relative_errors(found)
    return Validation(
        readings.quantity,
        pair,
        None if apart is None else apart.sizes,
        limit_mm,
        passed,
        claimed,
        distance_errors=None if apart is None else apart.errors,
        places=errors_by_place(model, found),
        relative=relative,
        decision=None if limit_mm is None else decide(found, known(model, found), limit_mm, rule),
        uncertainty=figure_uncertainty(model, found, apart, aligned=relative is not None),
        turns=turn_errors(model, readings),
    )


def _passes(position: NominalAndIdentified, limit_mm: float | None, claimed_mm: float) -> bool:
    """Whether a model passes, by a limit or by what it claims itself; the uncertainty does not count here."""
    if limit_mm is not None:
        return position.identified.max_mm <= limit_mm
    # A model far from what it claims does not know this robot, frame or unit, however bad the nominal one is.
    # What one claims is NaN where its file does not say how uncertain it is: nothing is in keeping with that.
    better = position.identified.mean_mm <= position.nominal.mean_mm
    return better and position.identified.mean_mm <= _BEYOND_CLAIM * claimed_mm
