"""Whether errors stay within a limit, with the uncertainty of measuring them counted.

ISO 14253-1:2017: conformity is proved where the value stays within the limit by more than the guard band,
nonconformity where it lies beyond the limit by more than that; in between nothing is proved. The guard band
is 1.65 standard uncertainties: 95 % of a normal distribution, one-sided.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.validation import Decision, DecisionRule, Verdict
from truepose.identification.verdict.judge import Judged
from truepose.judgement.figure import Figure
from truepose.judgement.uncertainty import PICOMETRES, Known

_COVERAGE: Final = 1.65


def decide(judged: Judged, known: Known, limit_mm: float, rule: DecisionRule) -> Decision:
    """Decide whether all errors of the identified model stay within a limit.

    Parameters
    ----------
    judged : Judged
        n >= 1 readings.
    known : Known
        What counts of their uncertainty: the instrument's, and that of where the robot stands. Scatter of
        the arm and errors of the model are what is judged.
    limit_mm : float
    rule : DecisionRule
        `simple` leaves the uncertainty out, so that something is always decided.

    Returns
    -------
    Decision
        With the guard band of the reading that decides.
    """
    errors = np.linalg.norm(judged.identified_mm, axis=1)
    guard = np.zeros_like(errors) if rule == "simple" else _COVERAGE * _uncertainty_mm(judged, known, errors)
    return _decision(errors, guard, limit_mm, rule)


def decide_figures(figures: Sequence[Figure], limit_mm: float, rule: DecisionRule) -> Decision:
    """Decide whether all of n >= 1 figures stay within a limit, whatever their sign; rules as `decide`."""
    sizes = np.array([abs(one.value) for one in figures])
    u = np.array([one.standard_uncertainty for one in figures])
    return _decision(sizes, np.zeros_like(u) if rule == "simple" else _COVERAGE * u, limit_mm, rule)


def _decision(errors: FloatArray, guard: FloatArray, limit_mm: float, rule: DecisionRule) -> Decision:
    beyond, within = errors - guard, errors + guard
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
    row = int(np.argmax(deciding))
    return Decision(rule, limit_mm, float(errors[row]), float(guard[row]), verdict)


def _uncertainty_mm(judged: Judged, known: Known, errors_mm: FloatArray) -> FloatArray:
    """Return the standard uncertainty along each error; of no error, along the worst way."""
    covariance = known.of_single()
    unit = judged.identified_mm / np.where(errors_mm > 0.0, errors_mm, 1.0)[:, None]
    along = np.einsum("ni,nij,nj->n", unit, covariance, unit)
    own = np.sqrt(np.where(errors_mm > 0.0, along, np.linalg.eigvalsh(covariance)[:, -1]))
    return np.asarray(np.round(own, PICOMETRES))
