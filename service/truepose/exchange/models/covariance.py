"""Covariance matrices as lists of rows, null where an entry is unknown."""

import math

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.exchange.document import Node
from truepose.exchange.json_text import Json, number_or_null

# Relative to the standard deviations: far above the rounding of products, far below a typing error.
_TOLERANCE = 1e-9


def read_covariance(node: Node, size: int) -> FloatArray:
    """Read a covariance, shape (size, size); null entries are NaN.

    Raises BadValueError for one that is not symmetric, or has a negative variance or a correlation above 1.
    """
    rows = [
        [math.nan if entry.is_null else entry.number() for entry in row.items(size)]
        for row in node.items(size)
    ]
    covariance: FloatArray = np.array(rows, float).reshape(size, size)
    variances = np.nan_to_num(np.diag(covariance))
    if np.any(variances < 0.0):
        node.fail("a covariance must not have negative variances")
    deviations = np.sqrt(variances)
    scale = np.outer(deviations, deviations)
    known = ~np.isnan(covariance) | ~np.isnan(covariance.T)
    asymmetry = np.abs(covariance - covariance.T)
    if np.any(known & ~(asymmetry <= _TOLERANCE * scale)):
        node.fail("a covariance must be symmetric")
    if np.any(np.abs(np.nan_to_num(covariance)) > (1.0 + _TOLERANCE) * scale):
        node.fail("a covariance must not have correlations beyond 1")
    return covariance


def covariance_document(covariance: FloatArray) -> Json:
    """Return the rows as lists, null for what is not finite."""
    return [[number_or_null(entry) for entry in row] for row in covariance.tolist()]
