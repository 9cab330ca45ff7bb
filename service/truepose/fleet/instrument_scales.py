"""The scales of instruments on their days: what explains them, by Student's t and Fisher's F.

An instrument's scale is free on every day that it measured, with a variance that the same days have to tell:
there the line or step is fitted to the scales of D days with that variance estimated anew, and judged by
Student's t with D - J - 1 degrees of freedom (J instruments). Two that change hide each other, as each is
scatter of days to the other; so two are tried together as well, by Fisher's F.

References
----------
D. A. Harville, J. American Statistical Association 72, 1977, 320-338.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.mixed_model import Posterior
from truepose.identification.distributions import f_exceeded

_UNSEEN: Final = 1e-10  # of the largest information on a day's scale: readings do not tell the scale
_WHOLLY: Final = 0.999  # of a day, in what is seen of all days
_SAME: Final = 1e-6  # of the largest of columns: what is left of one that is a sum of the others
_DAYS: Final = np.append(0.0, np.logspace(-8.0, 0.0, 81))  # variances of days, in squared stated widths


class Line(NamedTuple):
    """A change over the days of an instrument, as it is found at a variance of days."""

    likelihood: float  # its logarithm
    u: float  # standard uncertainty; inf: there is no column
    squared: float  # of all columns beyond the instruments' levels: F where nothing changed


class InstrumentDays:
    """The scales of instruments on their days, as far as readings tell them, and what explains them.

    Of D visits, r directions of their scales are told by readings, I = T diag(1 / v) T' with all else
    integrated out; there T' s ~ N(T' X beta, diag(v) + day I) with the levels of the instruments and the
    changes in X.

    Parameters
    ----------
    posterior : Posterior

    Attributes
    ----------
    told : ndarray of bool, shape (D,)
        Whether readings tell a day's scale.
    covariance : ndarray, shape (D, D)
        Of the scales, by the readings alone, in squared stated widths.
    scale : ndarray, shape (D,)
        In stated widths.
    """

    def __init__(self, posterior: Posterior) -> None:
        right, information = _of_days(posterior)
        values, vectors = np.linalg.eigh(information)
        seen = values > max(_UNSEEN * float(values[-1]), 1e-300)
        self._turns, self._variances = vectors[:, seen], 1.0 / values[seen]
        self._turned = self._variances * (self._turns.T @ right)
        self.told = (self._turns**2).sum(axis=1) > _WHOLLY  # (D,) whether readings tell a day's scale
        self.covariance = (self._turns * self._variances) @ self._turns.T  # (D, D) of the readings alone
        self.scale = self._turns @ self._turned  # (D,) in stated widths
        instrument = np.array([visit[0] for visit in posterior.equations.fleet.visits])
        self._levels = _spanning(self._turns.T @ (instrument[:, None] == np.unique(instrument)))
        self._without = self._best(()).likelihood

    def of(self, *changes: FloatArray) -> tuple[float, float]:
        """Return how much speaks for changes over the visits together, and the chance of so much.

        Parameters
        ----------
        changes : ndarray, shape (D,) each
            Shapes over the visits.

        Returns
        -------
        ratio : float
            Twice the log likelihood ratio; 0 where readings cannot tell them from levels.
        chance : float
            By Fisher's F; 1 there.
        """
        turned = [self._turns.T @ change for change in changes]
        left = self._left(turned)
        if left < 1:
            return 0.0, 1.0
        best = self._best(turned)
        chance = f_exceeded(best.squared, float(len(changes)), float(left))
        return max(2.0 * (best.likelihood - self._without), 0.0), chance

    def judging(self, shape: FloatArray) -> tuple[float, int]:
        """Return by what a change is judged.

        Parameters
        ----------
        shape : ndarray, shape (D,)
            Over the visits.

        Returns
        -------
        u : float
            Standard uncertainty in stated widths; inf where too few days are told.
        degrees : int
            Of freedom; 0 there.
        """
        turned = [self._turns.T @ shape]
        left = self._left(turned)
        return (self._best(turned).u, left) if left >= 1 else (np.inf, 0)

    def _left(self, turned: Sequence[FloatArray]) -> int:
        """Return the degrees of freedom beside changes; 0 where readings cannot tell these from levels."""
        columns = np.column_stack([self._levels, *turned])
        told = _spanning(columns).shape[1] == columns.shape[1]
        return len(columns) - columns.shape[1] if told else 0

    def _best(self, turned: Sequence[FloatArray]) -> "Line":
        """Return what of the last change is found at the likeliest variance of days.

        The variance of days is that of the restricted likelihood's scale: of D values, as many are free as
        columns leave.
        """
        columns = np.column_stack([self._levels, *turned])
        likelihood, found, inverse, squared = self._likeliest(columns)
        # What days scatter beyond this variance widens it, so that the largest likelihood is not taken at
        # its word by few days.
        spread = max(squared / max(len(columns) - columns.shape[1], 1), 1.0)
        if not len(turned):
            return Line(likelihood, np.inf, 0.0)
        beyond = slice(self._levels.shape[1], None)
        told = found[beyond] @ np.linalg.inv(inverse[beyond, beyond]) @ found[beyond]
        squared = float(told) / (len(turned) * spread)
        return Line(likelihood, float(np.sqrt(inverse[-1, -1] * spread)), squared)

    def _likeliest(self, turned: FloatArray) -> tuple[float, FloatArray, FloatArray, float]:
        """Fit columns (D, p) at every variance of days: the largest likelihood, its fit, and what is left."""
        weights = 1.0 / np.sqrt(self._variances + _DAYS[:, None])
        white, read = weights[:, :, None] * turned, (weights * self._turned)[:, :, None]
        rows = np.swapaxes(white, 1, 2)
        inverses = np.linalg.inv(rows @ white)
        found = inverses @ (rows @ read)
        squares = np.square(read - white @ found).sum(axis=(1, 2))
        likelihoods = np.log(weights).sum(axis=1) - 0.5 * squares
        best = int(np.argmax(likelihoods))
        return float(likelihoods[best]), found[best, :, 0], inverses[best], float(squares[best])


def _of_days(posterior: Posterior) -> tuple[FloatArray, FloatArray]:
    """Return what readings say of the scales of D days, all else integrated out: (D,) and (D, D)."""
    days = posterior.equations.visits
    others = np.delete(np.arange(len(posterior.information)), days)
    across = posterior.information[days, others]
    prior = posterior.equations.prior(posterior.variances.day)[np.ix_(others, others)]
    held = posterior.information[np.ix_(others, others)] + np.linalg.inv(prior)
    gain = np.linalg.solve(held, across.T).T
    # Not as the difference of two inverses: where a ballbar or a gauge measured, which tell no scale,
    # there are none.
    information = posterior.information[days, days] - gain @ across.T
    right = posterior.information_right
    return right[days] - gain @ right[others], 0.5 * (information + information.T)


def _spanning(columns: FloatArray) -> FloatArray:
    """Return columns at right angles (n, r) that span given ones, without those that are sums of others."""
    left, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(left[:, sizes > _SAME * sizes.max(initial=0.0)])
