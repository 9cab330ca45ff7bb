r"""The fitted model by its normal equations: what products keep once the present parameters took theirs.

With A the stacked whitened derivatives of observations and priors, A^T A = R^T R, a column g and the stacked
residual y keep, after the projection,

    g^T y - (R^-T A^T g)^T (R^-T A^T y),    g^T g - |R^-T A^T g|^2

so that leaving a parameter out, or fitting a random effect besides, costs a small Cholesky factor instead of
a pass over all observations. Parameters are brought to unit diagonal first.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import sites
from truepose.identification.fit.robust import RobustFit
from truepose.identification.observations.blocks import Block, BlockResult


def counted_rows(fit: RobustFit) -> BoolArray:
    """Return which of the stacked components are of readings that count, shape (m,)."""
    return np.concatenate([
        np.repeat(block.counts, result.residual.shape[1])
        for block, result in zip(fit.blocks, fit.results, strict=True)
    ])


def design_effect(block: Block, result: BlockResult) -> float:
    """How many readings of a stop are worth one: 1 + (m - 1) of their correlation.

    What a model lacks moves all nests that are read at one stop together; so does a stop that is revisited.
    """
    vectors = result.whitening.apply(result.residual)
    if result.direction is not None:
        vectors = vectors * result.direction
    kept = block.counts
    _, stop = np.unique(sites(block.targets.stops)[kept], return_inverse=True)
    vectors = vectors[kept]
    sizes = np.bincount(stop)
    sums = np.stack([np.bincount(stop, component) for component in vectors.T], axis=1)
    squares = float((vectors**2).sum())
    pairs = float((sizes * (sizes - 1)).sum())
    if pairs == 0.0 or squares == 0.0:
        return 1.0
    correlation = (float((sums**2).sum()) - squares) / pairs / (squares / len(vectors))
    usual = pairs / len(vectors)  # other readings of the same stop that a reading has on average
    return float(1.0 + usual * np.clip(correlation, 0.0, 1.0))


_ROUNDING = 1e-13  # added to the unit diagonal: a direction that only rounding supports


@dataclass(frozen=True, slots=True)
class Sums:
    """What is left of the residuals."""

    residual_square: float
    degrees: float  # of freedom
    observations: float  # readings that count, times their components
    alike: float  # how many readings of a stop are worth one

    @property
    def variance(self) -> float:
        """Variance of the whitened residuals: 1 where the weights are right."""
        return self.residual_square / max(self.degrees, 1.0)


@dataclass(frozen=True, slots=True)
class Products:
    """Products of K columns with the derivatives and the residuals of a fit."""

    columns: FloatArray  # (K, m)
    with_jacobian: FloatArray  # (K, P)
    with_residual: FloatArray  # (K,)

    def rows(self, chosen: slice | IntArray) -> "Products":
        """Return those of some columns."""
        return Products(self.columns[chosen], self.with_jacobian[chosen], self.with_residual[chosen])


def products_of(fit: RobustFit, columns: FloatArray) -> Products:
    """Return the products of columns (K, m) with a fit."""
    final = fit.solution.final
    return Products(columns, columns @ final.jacobian.T, columns @ final.residual)


@dataclass(frozen=True, slots=True)
class Projection:
    """Projection past some of the parameters."""

    kept: BoolArray  # (P,)
    root: FloatArray  # (q, q) upper triangular, of unit-scaled parameters
    scale: FloatArray  # (q,)
    removed: FloatArray  # (P - q,) values of the parameters left out
    of_residual: FloatArray  # (q,) the residual's coordinates in what is projected out
    sums: Sums

    def absorbed(self, products: Products) -> FloatArray:
        """Coordinates of columns in what is projected out, shape (K, q)."""
        return self.coordinates(products.with_jacobian)

    def coordinates(self, with_jacobian: FloatArray) -> FloatArray:
        """Coordinates of what has these products with the derivatives (K, P), shape (K, q)."""
        scaled = with_jacobian[:, self.kept] * self.scale
        return np.asarray(solve_triangular(self.root, scaled.T, trans="T").T)

    def parameters(self, coordinates: FloatArray) -> FloatArray:
        """Return the parameters kept that come nearest to something of these coordinates, shape (q,)."""
        return np.asarray(self.scale * solve_triangular(self.root, coordinates))

    def step(self) -> FloatArray:
        """Return what the parameters kept change by to the least sum of squares, shape (q,)."""
        return self.parameters(self.of_residual)

    def towards(self, products: Products, absorbed: FloatArray) -> FloatArray:
        """Products of columns with the residual that is left, shape (K,)."""
        raw = products.with_residual + products.with_jacobian[:, ~self.kept] @ self.removed
        return np.asarray(raw - absorbed @ self.of_residual)


@dataclass(frozen=True, slots=True)
class NormalEquations:
    """Normal equations of a fit, whose parameters may be left out again."""

    names: tuple[str, ...]
    values: FloatArray  # (P,)
    deviation: FloatArray  # (P,) prior mean less value
    widths: FloatArray  # (P,) of the priors
    squares: FloatArray  # (P, P) products of the derivatives
    towards: FloatArray  # (P,) their products with the residuals
    residual_square: float
    observations: float
    alike: float

    def past(self, without: tuple[str, ...] = ()) -> Projection:
        """Project past the parameters, as if `without` had not been fitted (to first order)."""
        kept = np.array([name not in without for name in self.names])
        removed = self.values[~kept]
        precision, deviation = 1.0 / self.widths[kept] ** 2, self.deviation[kept]
        matrix = self.squares[np.ix_(kept, kept)] + np.diag(precision)
        scale = 1.0 / np.sqrt(np.diag(matrix))
        unit = matrix * np.outer(scale, scale) + _ROUNDING * np.eye(len(scale))
        root = np.asarray(cholesky(unit))
        gradient = self.towards[kept] + self.squares[np.ix_(kept, ~kept)] @ removed + precision * deviation
        of_residual = np.asarray(solve_triangular(root, scale * gradient, trans="T"))
        square = (
            self.residual_square
            + 2.0 * float(removed @ self.towards[~kept])
            + float(removed @ self.squares[np.ix_(~kept, ~kept)] @ removed)
            + float(precision @ deviation**2)
            - float(of_residual @ of_residual)
        )
        sums = Sums(max(square, 1e-300), max(self.observations, 1.0), self.observations, self.alike)
        return Projection(kept, root, scale, removed, of_residual, sums)

    def beside(self, effects: Products, widths: FloatArray, names: tuple[str, ...]) -> "NormalEquations":
        """Return the normal equations with further parameters, at zero, whose priors have these widths."""
        across = effects.with_jacobian
        zeros = np.zeros(len(widths))
        return replace(
            self,
            names=(*self.names, *names),
            values=np.concatenate([self.values, zeros]),
            deviation=np.concatenate([self.deviation, zeros]),
            widths=np.concatenate([self.widths, widths]),
            squares=np.block([[self.squares, across.T], [across, effects.columns @ effects.columns.T]]),
            towards=np.concatenate([self.towards, effects.with_residual]),
        )


def normal_of(fit: RobustFit, rows: BoolArray | None = None) -> NormalEquations:
    """Return the normal equations of a fit, of some of its stacked observations (m,) alone where asked."""
    final, structure = fit.solution.final, fit.structure
    jacobian, residual, counted = final.jacobian, final.residual, counted_rows(fit)
    if rows is not None:
        jacobian, residual, counted = jacobian[:, rows], residual[rows], counted[rows]
    return NormalEquations(
        names=structure.names,
        values=fit.values,
        deviation=structure.prior_means - fit.values,
        widths=structure.prior_widths,
        squares=jacobian @ jacobian.T,
        towards=jacobian @ residual,
        residual_square=float(residual @ residual),
        observations=float(counted.sum()),
        alike=design_effect(fit.blocks[0], fit.results[0]),
    )
