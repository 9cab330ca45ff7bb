"""A model judged by readings that it was not made from: whether it keeps what it claims."""

from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Readings
from truepose.domain.results.identification import Model, NominalAndIdentified
from truepose.domain.results.validation import DecisionRule, Validation
from truepose.identification import judge
from truepose.identification.verdict.relative import relative_errors
from truepose.identification.verdict.turns import turn_errors
from truepose.judgement.decision import decide
from truepose.judgement.distances import distances
from truepose.judgement.places import errors_by_place
from truepose.judgement.uncertainty import figure_uncertainty, known

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
        raise ConfigurationError("There is no reading to validate with.")
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
    if limit_mm is not None:
        return position.identified.max_mm <= limit_mm
    # A model far from what it claims does not know this robot, frame or unit, however bad the nominal one is.
    better = position.identified.mean_mm <= position.nominal.mean_mm
    return better and position.identified.mean_mm <= _BEYOND_CLAIM * claimed_mm
