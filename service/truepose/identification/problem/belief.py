r"""What is believed of parameters together, as robots of one type tell it, as a part of a problem.

Stated priors are widths, one a parameter. A belief is a mean m and a full covariance S. In the stated widths
w, about the stated means n, it is worth

    S~^-1 = V l V'        S~ = S / (w w'),   y = S~^-1 (m - n) / w

of which each direction's first unit is the stated prior itself; what it knows beyond that enters as one
reading a direction, of sqrt(l - 1) v' p~ with the value that makes both together the belief. Directions of
which a belief knows less than was stated (l < 1) keep the stated prior. The stated widths of these parameters
therefore stay as they are (`identification.fit.robust` widens others where readings ask for it).

Sources: as `identification.fit.solver`; A. Gelman et al., Bayesian Data Analysis, 3rd ed., 2013, section 14.8
(a prior as further readings).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.effects.ports import ParameterSpec
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.believed import belief_block
from truepose.identification.problem.build import Problem


@dataclass(frozen=True, slots=True)
class Belief:
    """Parameters as they are believed to be before a robot is measured; internal units."""

    specs: tuple[ParameterSpec, ...]  # as stated
    owners: tuple[str, ...]  # effect of each
    mean: FloatArray  # (Q,)
    covariance: FloatArray  # (Q, Q)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(spec.name for spec in self.specs)

    def beyond_stated(self) -> tuple[FloatArray, FloatArray]:
        """Return rows (Q, Q) and readings (Q,) of what it knows beyond the stated priors.

        Rows are per unit of each parameter.

        Raises
        ------
        ConfigurationError
            The covariance is none: a variance in it is not positive.
        """
        widths = np.array([spec.prior_width for spec in self.specs])
        means = np.array([spec.prior_mean for spec in self.specs])
        spread, turns = np.linalg.eigh(self.covariance / np.outer(widths, widths))
        if not np.all(np.isfinite(spread)) or spread[0] <= 0.0:
            raise ConfigurationError("A belief has a covariance whose variances are all above 0.")
        known, deviation = 1.0 / spread, turns.T @ ((self.mean - means) / widths)
        root = np.sqrt(np.maximum(known - 1.0, 0.0))
        told = np.divide(known * deviation, root, out=np.zeros_like(root), where=root > 0.0)
        rows = root[:, None] * turns.T / widths
        return rows, told + rows @ means


def with_belief(problem: Problem, belief: Belief) -> Problem:
    """Return the problem with what is believed of its parameters; those that it lacks are added.

    Raises
    ------
    ConfigurationError
        The covariance is none.
    """
    structure, start = problem.structure, problem.start
    for effect in dict.fromkeys(belief.owners):
        new = tuple(
            spec
            for spec, owner in zip(belief.specs, belief.owners, strict=True)
            if owner == effect and spec.name not in structure.names
        )
        structure = structure.extended(effect, new)
        start = np.append(start, [spec.prior_mean for spec in new])
    rows, read = belief.beyond_stated()
    telling = rows.any(axis=1)
    rows, read = rows[telling], read[telling]
    block = belief_block(
        belief.names, (rows, read), (belief.mean, belief.covariance), structure.robot.n_joints
    )
    blocks = (*problem.blocks, block) if len(read) else problem.blocks
    return replace(problem, structure=structure, start=start, blocks=blocks)


def precision_of(structure: Structure, belief: Belief | None) -> FloatArray:
    """Return what is known beforehand of a structure's parameters in their stated widths, shape (P, P)."""
    precision = np.eye(len(structure.specs))
    if belief is None:
        return precision
    rows, _ = belief.beyond_stated()
    place: Callable[[str], int] = structure.index_of
    at = np.array([place(name) for name in belief.names], dtype=np.int64)
    white = rows * structure.prior_widths[at]
    precision[np.ix_(at, at)] += white.T @ white
    return precision
