"""What is left: whether the residuals of a model hold structure, and what it depends on.

Every family is tested as a random effect on the residuals (score test of a variance component); the level is
controlled over all families. The noise is not known: its size is taken from the residuals themselves.
"""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.screening.columns import term_columns
from truepose.diagnosis.screening.normal_equations import Products, Projection, products_of
from truepose.diagnosis.screening.random_functions import chance, most_likely
from truepose.diagnosis.screening.smooth_families import Family, families, terms_of
from truepose.domain.arrays import FloatArray
from truepose.effects.causes import Scene
from truepose.identification.fit.robust import RobustFit

Prepared = tuple[Family, Products]


@dataclass(frozen=True, slots=True)
class Structured:
    """A family and how improbable its share of the residuals is by chance."""

    family: Family
    p_value: float  # corrected for all families
    products: Products


def prepared_families(fit: RobustFit, scene: Scene) -> tuple[Prepared, ...]:
    """Return every family with its whitened columns; those of a variable that says nothing are left out."""
    found = []
    for family in families(scene):
        terms = [terms_of(family, result.state) for result in fit.results]
        count = 1 + max((term.parameter for acting in terms for term in acting), default=-1)
        columns = term_columns(fit, terms, count)
        if float(np.abs(columns).max(initial=0.0)) > 0.0:
            found.append((family, products_of(fit, columns)))
    return tuple(found)


def structured(prepared: tuple[Prepared, ...], past: Projection) -> tuple[Structured, ...]:
    """Test every family past what is fitted, the most improbable first."""
    found = [
        Structured(family, min(1.0, len(prepared) * _p_value(products, past)), products)
        for family, products in prepared
    ]
    return tuple(sorted(found, key=lambda one: one.p_value))


def _left(products: Products, past: Projection) -> tuple[FloatArray, FloatArray]:
    """Products among columns, and with the residuals, once the present parameters took theirs."""
    absorbed = past.absorbed(products)
    gram = products.columns @ products.columns.T - absorbed @ absorbed.T
    return np.asarray(gram), past.towards(products, absorbed)


def _p_value(products: Products, past: Projection) -> float:
    return chance(*_left(products, past), past.sums)


@dataclass(frozen=True, slots=True)
class RandomEffect:
    """A family as a random effect of its most likely size."""

    width: float  # standard deviation of its parameters, 0 where none is seen
    score: float  # gain in BIC: twice the log likelihood, less what its one parameter costs


def as_random_effect(products: Products, past: Projection) -> RandomEffect:
    """Fit a family as a random effect (maximum likelihood, size of the noise profiled out)."""
    found = most_likely(*_left(products, past), past.sums)
    cost = float(np.log(max(past.sums.observations / past.sums.alike, 2.0)))
    return RandomEffect(found.width, found.gain - cost)
