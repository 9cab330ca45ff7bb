"""The linear problem of a fit as plain least squares, which normal equations and projections agree with."""

import numpy as np


def stacked(fit):
    """Derivatives (m + P, P) and residuals (m + P,) of observations and priors."""
    structure, final = fit.structure, fit.solution.final
    matrix = np.vstack([final.jacobian.T, np.diag(1.0 / structure.prior_widths)])
    return matrix, np.append(final.residual, (structure.prior_means - fit.values) / structure.prior_widths)


def left_square(matrix, residual):
    """Sum of squares that a least-squares fit leaves, columns scaled so that rounding stays small."""
    unit = matrix / np.linalg.norm(matrix, axis=0)
    return float(np.sum((residual - unit @ np.linalg.lstsq(unit, residual, rcond=None)[0]) ** 2))


def left_square_beside(fit, columns, widths):
    """What a fit with k further parameters would leave: whitened derivatives (k, m), prior widths (k,)."""
    matrix, residual = stacked(fit)
    k, p = len(columns), matrix.shape[1]
    wider = np.block([
        [matrix, np.vstack([columns.T, np.zeros((p, k))])],
        [np.zeros((k, p)), np.diag(1.0 / np.asarray(widths))],
    ])
    return left_square(wider, np.append(residual, np.zeros(k)))
