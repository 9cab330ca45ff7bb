"""What is believed of parameters together, as readings of sums of them: one a row, each of variance 1.

A belief of Q parameters has mean m and covariance S. Its rows a and readings z, one for each direction of
which it knows more than was stated, enter as

    residual = z - a . p        variance 1

so that they and the stated priors together are the belief (`problem.build`). Of a robot of the type the
estimate p with covariance C then lies off the mean by

    (p - m)' (S - C)^+ (p - m)  ~  chi-square

over the directions of which readings have taught something.
"""

from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple, Self

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.campaign import Stops
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import BlockResult, ObservationBlock, Whitener

QUANTITY = "belief"
_TAUGHT: Final = 0.01  # share of a direction's variance that readings took away; less tells nothing


class Unlikeness(NamedTuple):
    """How far a robot lies off what is believed of its type.

    Attributes
    ----------
    chance : float
        That a robot of the type lies as far off, 0 to 1.
    parameter : str
        That lies off most.
    off_u : float
        By how much, in the standard uncertainties of what readings taught.
    """

    chance: float
    parameter: str
    off_u: float


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefBlock(ObservationBlock):
    """Sums of parameters and what they are believed to be; none is ever gross, and each counts in full.

    Attributes
    ----------
    names : tuple of str, length Q
        Of the parameters.
    rows : ndarray, shape (S, Q)
        Sums of them, per internal unit of each.
    read : ndarray, shape (S,)
        What the sums are believed to be [1].
    mean : ndarray, shape (Q,)
        What is believed of the parameters altogether, internal units.
    believed : ndarray, shape (Q, Q)
        Its covariance.
    """

    quantity: ClassVar[str] = QUANTITY
    table: ClassVar[str] = "belief"
    components: ClassVar[int] = 1
    # What a model lacks is no reason to know less of the robots of a type.
    of_arm: ClassVar[bool] = False

    names: tuple[str, ...]
    rows: FloatArray
    read: FloatArray
    mean: FloatArray
    believed: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives; parameters as of `ObservationBlock.result`.

        Returns
        -------
        BlockResult
            Residual (S, 1) [1]: what sums are believed to be minus what they are. Parameters that a structure
            lacks stand at 0.
        """
        state = self.evaluated(structure, values, previous)
        value = dict(zip(structure.names, values.tolist(), strict=True))
        believed = self.rows @ np.array([value.get(name, 0.0) for name in self.names])
        residual = (self.read - believed)[:, None]
        return BlockResult(residual, self.differentiated(state), state, _each_alone(len(self.read)))

    def derivatives(self, state: State) -> FloatArray:
        """Return the sums themselves.

        Parameters
        ----------
        state : State

        Returns
        -------
        ndarray, shape (P, S, 1)
            Per internal unit; zeros for parameters of which nothing is believed.
        """
        names = state.structure.names
        jacobian = np.zeros((len(names), len(self.read), 1))
        for column, name in enumerate(self.names):
            if name in names:
                jacobian[names.index(name), :, 0] = self.rows[:, column]
        return jacobian

    def covariance(self) -> FloatArray:
        """Return variances of 1, shape (S, 1, 1)."""
        return np.ones((len(self.read), 1, 1))

    def component_variance(self) -> FloatArray:
        """Return variances of 1, shape (S,)."""
        return np.ones(len(self.read))

    def stated_sigma(self) -> float:
        """Return 0: no instrument states it."""
        return 0.0

    def squared(self, result: BlockResult) -> FloatArray:
        """Return squared residuals, shape (S,)."""
        return np.asarray(result.residual[:, 0] ** 2)

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return the result as it is."""
        return result

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block as it is: no misfit of readings makes a belief less known."""
        return self

    def own_discrepancy(self) -> float | None:
        """Return 0."""
        return 0.0

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return none."""
        return np.zeros_like(off)

    def held(self) -> frozenset[str]:
        """Return its parameters: what is believed of them counts on their stated widths."""
        return frozenset(self.names)

    def unlikeness(self, structure: Structure, values: FloatArray, covariance: FloatArray) -> Unlikeness:
        """Return how far a robot that was identified with the belief lies off it.

        Of a robot of the type the estimate p lies off the mean m by as much as the readings taught,
        p - m ~ N(0, S - C), with the belief's covariance S and the estimate's C.

        Parameters
        ----------
        structure : Structure
            Of the fit, with all Q parameters.
        values : ndarray, shape (P,)
            Internal units.
        covariance : ndarray, shape (P, P)
            Of the values.

        Returns
        -------
        Unlikeness
            With a chance of 1 where readings taught nothing.

        References
        ----------
        R. A. Johnson, D. W. Wichern, Applied Multivariate Statistical Analysis, 6th ed., 2007, section 4.6.
        """
        at = np.array([structure.names.index(name) for name in self.names], dtype=np.int64)
        off = values[at] - self.mean
        taught = self.believed - covariance[np.ix_(at, at)]
        # In units of the belief: of its directions those are asked that readings made narrower.
        root = np.linalg.cholesky(self.believed)
        white = np.linalg.solve(root, np.linalg.solve(root, taught).T)
        share, turns = np.linalg.eigh(0.5 * (white + white.T))
        # Along a direction of which readings taught nothing the estimate is the belief, off by rounding
        # alone.
        known = share > _TAUGHT
        squared = (turns.T @ np.linalg.solve(root, off))[known] ** 2 / share[known]
        # A parameter of which nothing was taught has a variance of 0 here and must not look infinitely off.
        each = np.abs(off) / np.sqrt(np.maximum(np.diag(taught), _TAUGHT * np.diag(self.believed)))
        most = int(np.argmax(each))
        chance = chi2_exceeded(float(squared.sum()), float(known.sum())) if known.any() else 1.0
        return Unlikeness(chance, self.names[most], float(each[most]))


def belief_block(
    names: tuple[str, ...],
    told: tuple[FloatArray, FloatArray],
    believed: tuple[FloatArray, FloatArray],
    n_joints: int,
) -> BeliefBlock:
    """Return the block of Q named parameters.

    Parameters
    ----------
    names : tuple of str
    told : tuple of ndarray, shapes (S, Q) and (S,)
        Sums of the parameters, and what they are, each of variance 1.
    believed : tuple of ndarray, shapes (Q,) and (Q, Q)
        Mean and covariance of the parameters, internal units.
    n_joints : int
    """
    rows, read = told
    n = len(read)
    # Numbers that no configuration of an arm has: nothing is shared with one.
    stops = Stops(config=-(10**9) - np.arange(n), joints_rad=np.zeros((n, n_joints)))
    targets = Targets(stops, np.ones(n, dtype=np.int64))
    mean, covariance = believed
    return BeliefBlock(
        targets=targets,
        weights=np.ones(n),
        names=names,
        rows=rows,
        read=read,
        mean=mean,
        believed=covariance,
    )


def _each_alone(n: int) -> Whitener:
    return Whitener((), np.ones(n))
