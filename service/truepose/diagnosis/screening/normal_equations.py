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
from truepose.identification.observations.blocks import BlockResult, ObservationBlock


def counted_rows(fit: RobustFit) -> BoolArray:
    """Return which of the stacked components are of readings that count.

    Parameters
    ----------
    fit : RobustFit

    Returns
    -------
    ndarray of bool, shape (m,)
        Over all blocks, a reading's components side by side; false of readings without weight.
    """
    return np.concatenate([
        np.repeat(block.counts, result.residual.shape[1])
        for block, result in zip(fit.blocks, fit.results, strict=True)
    ])


def design_effect(block: ObservationBlock, result: BlockResult) -> float:
    """Return how many readings of a stop are worth one: 1 + (m - 1) of their correlation.

    What a model lacks moves all nests that are read at one stop together; so does a stop that is revisited.
    With x_s the sum of the whitened residual vectors of stop s, of which there are n_s, and x_i single ones,

        rho = (sum |x_s|^2 - sum |x_i|^2) / (sum n_s (n_s - 1)) / (mean |x_i|^2),

    the intraclass correlation, and the effect is 1 + rho times the mean number of other readings of a stop.

    Parameters
    ----------
    block : ObservationBlock
        Of readings of the arm, n of them with weight.
    result : BlockResult
        The block at the fit.

    Returns
    -------
    float
        1 where every stop has one reading, or where readings of a stop err independently.

    References
    ----------
    L. Kish, Survey Sampling, 1965, section 5.4.
    """
    vectors = result.whitening.apply(result.residual)
    # Lengths have one component along the bar. Correlated is what moves the nest in space, so they are
    # compared as vectors.
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
    # A negative correlation is chance here; taken at its word, readings would count for more than they are.
    return float(1.0 + usual * np.clip(correlation, 0.0, 1.0))


_ROUNDING = 1e-13  # added to the unit diagonal: a direction that only rounding supports


@dataclass(frozen=True, slots=True)
class Sums:
    """Sums over the residuals that a projection leaves.

    Attributes
    ----------
    residual_square : float
        Of whitened residuals, deviations from the priors included; above 0.
    degrees : float
        Of freedom.
    observations : float
        Readings that count, times their components.
    alike : float
        How many readings of a stop are worth one (`design_effect`), >= 1.
    """

    residual_square: float
    degrees: float
    observations: float
    alike: float

    @property
    def variance(self) -> float:
        """Variance of the whitened residuals: 1 where the weights are right."""
        return self.residual_square / max(self.degrees, 1.0)


@dataclass(frozen=True, slots=True)
class Products:
    """Products of K columns with the derivatives and the residuals of a fit.

    Attributes
    ----------
    columns : ndarray, shape (K, m)
        Whitened derivatives of the stacked observations.
    with_jacobian : ndarray, shape (K, P)
        Their products with the derivatives of the fitted parameters.
    with_residual : ndarray, shape (K,)
        Their products with the residuals.
    """

    columns: FloatArray
    with_jacobian: FloatArray
    with_residual: FloatArray

    def rows(self, chosen: slice | IntArray) -> "Products":
        """Return the products of some columns.

        Parameters
        ----------
        chosen : slice or ndarray of int

        Returns
        -------
        Products
        """
        return Products(self.columns[chosen], self.with_jacobian[chosen], self.with_residual[chosen])


def products_of(fit: RobustFit, columns: FloatArray) -> Products:
    """Return the products of columns with a fit.

    Parameters
    ----------
    fit : RobustFit
        Of P parameters and m stacked observations.
    columns : ndarray, shape (K, m)
        Whitened as the fit's own derivatives are.

    Returns
    -------
    Products
    """
    final = fit.solution.final
    return Products(columns, columns @ final.jacobian.T, columns @ final.residual)


@dataclass(frozen=True, slots=True)
class Projection:
    """Projection past q of the P parameters.

    Attributes
    ----------
    kept : ndarray of bool, shape (P,)
        Which parameters are projected out.
    root : ndarray, shape (q, q)
        R, upper triangular: R^T R = A^T A of the parameters in units of `scale`.
    scale : ndarray, shape (q,)
        One over the root of the diagonal of A^T A.
    removed : ndarray, shape (P - q,)
        Values of the parameters left out.
    of_residual : ndarray, shape (q,)
        R^-T A^T y, the residual's coordinates in what is projected out.
    sums : Sums
        Of what is left.
    """

    kept: BoolArray
    root: FloatArray
    scale: FloatArray
    removed: FloatArray
    of_residual: FloatArray
    sums: Sums

    def absorbed(self, products: Products) -> FloatArray:
        """Return the coordinates of columns in what is projected out: R^-T A^T g.

        Parameters
        ----------
        products : Products
            Of K columns.

        Returns
        -------
        ndarray, shape (K, q)
            Scalar products of two rows are what two columns lose of theirs.
        """
        return self.coordinates(products.with_jacobian)

    def coordinates(self, with_jacobian: FloatArray) -> FloatArray:
        """Return the coordinates of what has these products with the derivatives.

        Parameters
        ----------
        with_jacobian : ndarray, shape (K, P)

        Returns
        -------
        ndarray, shape (K, q)
        """
        scaled = with_jacobian[:, self.kept] * self.scale
        return np.asarray(solve_triangular(self.root, scaled.T, trans="T").T)

    def parameters(self, coordinates: FloatArray) -> FloatArray:
        """Return the parameters kept that come nearest to something of these coordinates.

        Parameters
        ----------
        coordinates : ndarray, shape (q,)

        Returns
        -------
        ndarray, shape (q,)
            Internal units of the parameters.
        """
        return np.asarray(self.scale * solve_triangular(self.root, coordinates))

    def step(self) -> FloatArray:
        """Return what the parameters kept change by to the least sum of squares.

        Returns
        -------
        ndarray, shape (q,)
            Internal units; 0 to first order where nothing was left out of a converged fit.
        """
        return self.parameters(self.of_residual)

    def towards(self, products: Products, absorbed: FloatArray) -> FloatArray:
        """Return the products of columns with the residual that is left.

        Parameters
        ----------
        products : Products
            Of K columns.
        absorbed : ndarray, shape (K, q)
            Their coordinates, as `absorbed` returns them.

        Returns
        -------
        ndarray, shape (K,)
        """
        # What a removed parameter had explained is in the residual again.
        raw = products.with_residual + products.with_jacobian[:, ~self.kept] @ self.removed
        return np.asarray(raw - absorbed @ self.of_residual)


@dataclass(frozen=True, slots=True)
class NormalEquations:
    """Normal equations of a fit, whose parameters may be left out again.

    Attributes
    ----------
    names : tuple of str
        Of the P parameters.
    values : ndarray, shape (P,)
    deviation : ndarray, shape (P,)
        Prior mean less value.
    widths : ndarray, shape (P,)
        Standard deviations of the priors.
    squares : ndarray, shape (P, P)
        Products of the whitened derivatives, priors not included.
    towards : ndarray, shape (P,)
        Their products with the residuals.
    residual_square : float
        Of the whitened residuals alone.
    observations : float
        Components of readings that count.
    alike : float
        As of `Sums`.
    """

    names: tuple[str, ...]
    values: FloatArray
    deviation: FloatArray
    widths: FloatArray
    squares: FloatArray
    towards: FloatArray
    residual_square: float
    observations: float
    alike: float

    def past(self, without: tuple[str, ...] = ()) -> Projection:
        """Project past the parameters, as if some of them had not been fitted (to first order).

        Parameters
        ----------
        without : tuple of str
            Parameters that are left out; their values go back into the residuals.

        Returns
        -------
        Projection
        """
        kept = np.array([name not in without for name in self.names])
        removed = self.values[~kept]
        precision, deviation = 1.0 / self.widths[kept] ** 2, self.deviation[kept]
        matrix = self.squares[np.ix_(kept, kept)] + np.diag(precision)
        # Radians and millimetres differ by so much that rounding would decide which directions are seen.
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
        # Degrees are as many as readings: each parameter takes one away, and its prior, an observation too,
        # adds one.
        sums = Sums(max(square, 1e-300), max(self.observations, 1.0), self.observations, self.alike)
        return Projection(kept, root, scale, removed, of_residual, sums)

    def beside(self, effects: Products, widths: FloatArray, names: tuple[str, ...]) -> "NormalEquations":
        """Return the normal equations with k further parameters, at zero.

        Parameters
        ----------
        effects : Products
            Of their columns with this fit, (k, m).
        widths : ndarray, shape (k,)
            Of their priors, whose means are zero.
        names : tuple of str
            k names.

        Returns
        -------
        NormalEquations
            Of P + k parameters.
        """
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
    """Return the normal equations of a fit.

    Parameters
    ----------
    fit : RobustFit
    rows : ndarray of bool, shape (m,), optional
        Of these stacked observations alone.

    Returns
    -------
    NormalEquations
    """
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
