"""What is left: is there structure in the residuals of a model, and what does it depend on?

Every family is tested as a random effect on the residuals (score test of a variance component). The waves of
all orders of every joint are tested one by one besides. The level is controlled over everything tried.

References
----------
X. Lin, Biometrika 84(2), 1997, 309-326 (variance-component score tests).
"""

from dataclasses import dataclass

import numpy as np

from service.diagnosis.columns import term_columns
from service.diagnosis.families import Family, families, terms_of
from service.diagnosis.footing import Footing
from service.diagnosis.quadratic import tail_probability
from service.domain.arrays import FloatArray
from service.effects.causes import Scene
from service.identification.robust import RobustFit


@dataclass(frozen=True, slots=True)
class Structured:
    """A family and how improbable its share of the residuals is by chance."""

    family: Family
    p_value: float  # corrected for all families
    columns: FloatArray  # (k, m)


def prepared_families(fit: RobustFit, scene: Scene) -> tuple[tuple[Family, FloatArray], ...]:
    """Return every family with its whitened columns; those of a variable that says nothing are left out."""
    found = []
    for family in families(scene):
        terms = [terms_of(family, result.state) for result in fit.results]
        count = 1 + max((term.parameter for acting in terms for term in acting), default=-1)
        columns = term_columns(fit, terms, count)
        if float(np.abs(columns).max(initial=0.0)) > 0.0:
            found.append((family, columns))
    return tuple(found)


def structured(prepared: tuple[tuple[Family, FloatArray], ...], footing: Footing) -> tuple[Structured, ...]:
    """Test every family on a footing, the most improbable first."""
    found = [
        Structured(family, min(1.0, len(prepared) * _p_value(columns, footing)), columns)
        for family, columns in prepared
    ]
    return tuple(sorted(found, key=lambda one: one.p_value))


def _p_value(columns: FloatArray, footing: Footing) -> float:
    towards = columns @ footing.residual[: footing.size]
    absorbed = footing.absorbed(columns)
    gram = columns @ columns.T - absorbed @ absorbed.T
    weights = np.maximum(np.linalg.eigvalsh(gram), 0.0)
    statistic = float(towards @ towards) / footing.variance / footing.alike
    return tail_probability(statistic, weights, footing.degrees / footing.alike)


@dataclass(frozen=True, slots=True)
class RandomEffect:
    """A family as a random effect of its most likely size."""

    width: float  # standard deviation of its parameters, 0 where none is seen
    score: float  # gain in BIC: twice the log likelihood, less what its one parameter costs


_SIZES = np.logspace(-4.0, 6.0, 61)  # ratios of the two variances that are tried, over the typical eigenvalue


def as_random_effect(columns: FloatArray, footing: Footing) -> RandomEffect:
    """Fit a family as a random effect (maximum likelihood, size of the noise profiled out).

    Parameters
    ----------
    columns : ndarray, shape (k, m)
    footing : Footing
    """
    absorbed = footing.absorbed(columns)
    sizes, axes = np.linalg.eigh(columns @ columns.T - absorbed @ absorbed.T)
    seen = sizes > 1e-9 * max(float(sizes.max(initial=0.0)), 1e-300)
    if not seen.any():
        return RandomEffect(0.0, -np.inf)
    sizes = sizes[seen]
    along = (axes[:, seen].T @ (columns @ footing.residual[: footing.size])) ** 2 / sizes
    ratios = _SIZES[:, None] / float(sizes.max())
    shrunk = ratios * sizes / (1.0 + ratios * sizes)
    left = footing.residual_square - shrunk @ along
    degrees = footing.degrees / footing.alike
    gain = degrees * np.log(footing.residual_square / left) - np.log1p(ratios * sizes).sum(axis=1)
    best = int(np.argmax(gain))
    variance = float(left[best]) / max(footing.degrees, 1.0)
    cost = np.log(max(footing.observations / footing.alike, 2.0))
    return RandomEffect(float(np.sqrt(ratios[best, 0] * variance)), float(gain[best] - cost))
