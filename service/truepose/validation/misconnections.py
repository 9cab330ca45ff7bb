"""What a person may have connected instead of what was asked, and how well readings go with it.

The figures are those of human reliability tables, for want of anybody who has counted slips with a ballbar.
They matter little where the evidence is clear; between, they say how soon a person is asked.

The likelihood is a Gaussian of all readings at once. The true lengths x of all pairs at one stop are foreseen
as N(f, S). A reading of pair i is x_i plus the reading's own error and that of the zero. If the readings y
are of pairs a = (a_1 .. a_k), which may repeat,

    y ~ N(f_a, s^2 S_aa + (u_reading^2 + u_zero^2) I)

so readings of one pair agree within the instrument, readings of two pairs share what their forecasts have in
common, and readings already kept sharpen the forecast of the next. A pair that is none of them ("nothing": a
ball beside its cup, a length of another stop) may show anything within the range.

The scale s stands for forecasts that claim too much: what a model lacks is in no covariance. It is the same
for all legs of a stop, so the first readings teach how far to trust the forecast of the others.

References
----------
A. D. Swain, H. E. Guttmann, Handbook of Human Reliability Analysis, NUREG/CR-1278, 1983: table 20-12,
selection among similar controls identified by labels only, 0.003; table 20-7, omission of an item of a short
list with check-off, 0.001; table 20-16, twice to five times that for a novice or under strain.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations, product

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import Leg, PoseForecast, SuspicionKind
from truepose.domain.errors import ConfigurationError

_SELECTION = 0.01  # another pair than asked: three times the table, the person stands and turns to the tablet
_OMISSION = 0.001  # left where it was, or put back where it had been, for each leg already read
_OTHERS = 8  # pairs beside the asked one, at least: three cups by three nests
_FOLLOWED = 0.5  # having taken B for A, a person takes A for B when B is asked
_NOTHING = 0.0002  # rarer: a ball beside its cup is felt, and its length does not stand still
_REAFFIRMED = 0.1  # was asked whether the pair is read twice, and said no though it is
_ALL_ORDERS = 6  # up to so many readings all orders are tried (720), beyond that those that move three


def slips(asked: Sequence[int], pairs: int, *, questioned: bool) -> tuple[IntArray, FloatArray]:
    """Return what k readings may be of, the first row being what was asked, and the log of their odds.

    Every reading may be of another pair, of a pair that another reading is of, or of nothing; two readings
    may be wrong in that way, or any may have changed places.

    Parameters
    ----------
    asked : sequence of int
        Rows of the pairs that were asked for, k of them.
    pairs : int
        How many pairs there are.
    questioned : bool
        The readings were judged one by one before. A pair that is read twice needs no forecast to be seen, so
        the person was asked at once where it looked like that, and maintained that it was not.

    Returns
    -------
    assignments : ndarray of int, shape (m, k)
        `pairs` stands for nothing. An account that can come about in two ways stands there twice.
    log_odds : ndarray, shape (m,)
        Before any evidence, against the first row.
    """
    own = np.array(asked, dtype=np.int64)
    single = _single(own, pairs, questioned)
    parts = [(own[None], np.zeros(1)), single, _double(own, *single), _orders(own, pairs)]
    return np.concatenate([rows for rows, _ in parts]), np.concatenate([odds for _, odds in parts])


def next_slips(own: int, pairs: int, asked: Sequence[int], taken: IntArray, *, affirmed: bool) -> FloatArray:
    """Return the log of the odds of what the next reading may be of, for each of m accounts of those before.

    Parameters
    ----------
    own : int
        Row of the pair that is asked for.
    pairs : int
        How many pairs there are.
    asked : sequence of k int
        What the readings at this stop were asked for so far.
    taken : ndarray of int, shape (m, k)
        What they are of.
    affirmed : bool
        A person was asked about the reading and maintained that it is of the pair.

    Returns
    -------
    ndarray, shape (m, pairs + 1)
        The last column stands for nothing.
    """
    accounts = len(taken)
    odds = np.full((accounts, pairs + 1), _SELECTION / _others(pairs))
    rows, readings = np.nonzero(taken < pairs)
    # At most once however often it was read: it is one place to put the bar back to.
    again = np.zeros((accounts, pairs + 1), dtype=bool)
    again[rows, taken[rows, readings]] = True
    odds += _OMISSION * again
    odds[:, pairs] = _NOTHING
    odds[:, own] = 1.0 - _SELECTION
    rows, readings = np.nonzero((taken == own) & (np.array(asked, dtype=np.int64) != own))
    # The asked pair was read already for another: who took B for A is likely to take A for B now.
    odds[rows, own] = 1.0 - _FOLLOWED
    odds[rows, np.array(asked, dtype=np.int64)[readings]] = _FOLLOWED
    if affirmed:
        odds[:, np.arange(pairs + 1) != own] *= _REAFFIRMED
    return np.asarray(np.log(odds))


def total(log_odds: FloatArray) -> float:
    """Return the log of the sum of odds that are given by their logarithms.

    Parameters
    ----------
    log_odds : ndarray, shape (m,)

    Returns
    -------
    float
        Minus infinity of none.
    """
    return float(np.logaddexp.reduce(log_odds))


def likeliest(assignments: IntArray, log_odds: FloatArray) -> tuple[IntArray | None, float]:
    """Return the best account of those that name the likeliest pair for the last reading.

    A prompt names one pair, so all accounts in which the reading is of that pair count together.

    Parameters
    ----------
    assignments : ndarray of int, shape (m, k)
        As of `slips`.
    log_odds : ndarray, shape (m,)

    Returns
    -------
    account : ndarray of int, shape (k,), or None
        None of no accounts.
    log_odds : float
        Of all accounts that name the pair.
    """
    if not len(assignments):
        return None, -np.inf
    named = np.unique(assignments[:, -1])
    shares = [total(log_odds[assignments[:, -1] == pair]) for pair in named]
    number = int(np.argmax(shares))
    chosen = assignments[:, -1] == named[number]
    return assignments[chosen][int(np.argmax(log_odds[chosen]))], shares[number]


def slip_kind(account: IntArray, asked: IntArray, instead: int, pairs: int) -> SuspicionKind:
    """Return the kind of a slip: no pair, another one, one that was read already, or two exchanged.

    Parameters
    ----------
    account, asked : ndarray of int, shape (k,)
        What the readings are of, and what they were asked for.
    instead : int
        What one of them is of; `pairs` stands for nothing.
    pairs : int
        How many pairs there are.

    Returns
    -------
    str
        Where the reading that the pair was asked for is of it too, it was read twice; else two changed
        places.
    """
    if instead == pairs:
        return "unlikely"
    own = np.flatnonzero(asked == instead)
    if not len(own):
        return "other_pair"
    return "same_pair" if account[own[0]] == instead else "exchanged"


def _single(own: IntArray, pairs: int, questioned: bool) -> tuple[IntArray, FloatArray]:
    """Return all accounts in which one reading is of something else."""
    reading, instead = np.indices((len(own), pairs + 1)).reshape(2, -1)
    other = instead != own[reading]
    reading, instead = reading[other], instead[other]
    rows = np.tile(own, (len(reading), 1))
    rows[np.arange(len(reading)), reading] = instead
    again = (_SELECTION / _others(pairs) + _OMISSION) * (_REAFFIRMED if questioned else 1.0)
    # A pair that another reading is of may also simply not have been left: an omission besides a confusion.
    odds = np.where(np.isin(instead, own), again, _SELECTION / _others(pairs))
    return rows, np.log(np.where(instead == pairs, _NOTHING, odds))


def _double(own: IntArray, rows: IntArray, odds: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return all accounts in which two readings are of something else, each for itself."""
    first, second = np.triu_indices(len(rows), 1)
    changed = (rows != own).argmax(axis=1)
    apart = changed[first] != changed[second]
    first, second = first[apart], second[apart]
    both = np.where(rows[first] != own, rows[first], rows[second])
    return both, odds[first] + odds[second]


def _orders(own: IntArray, pairs: int) -> tuple[IntArray, FloatArray]:
    """Return all accounts in which readings changed places; each further one that moves is another slip."""
    count = len(own)
    most = count if count <= _ALL_ORDERS else 3
    rows, odds = [], []
    for moved in range(2, most + 1):
        cycles = [order for order in permutations(range(moved)) if all(i != j for i, j in enumerate(order))]
        for chosen, order in product(combinations(range(count), moved), cycles):
            row = own.copy()
            # One slip that is followed up; each place that is taken, but for the last, is one among all other
            # pairs.
            row[list(chosen)] = own[[chosen[place] for place in order]]
            rows.append(row)
            odds.append(np.log(_SELECTION * _FOLLOWED) - (moved - 1) * np.log(_others(pairs)))
    return np.array(rows, dtype=np.int64).reshape(len(rows), count), np.array(odds)


def _others(pairs: int) -> int:
    """Return how many pairs a person may confuse a pair with, at least eight."""
    return max(pairs - 1, _OTHERS)


# One stop in 25 is foreseen half as well as claimed, one in a hundred a quarter.
_SCALES = ((1.0, 0.95), (2.0, 0.04), (4.0, 0.01))


@dataclass(frozen=True, slots=True, eq=False)
class LengthForecast:
    """What is known of the lengths at one stop before they are read.

    Attributes
    ----------
    pairs : tuple of Leg
        p pairs that can be told apart.
    length_mm : ndarray, shape (p,)
    covariance_mm2 : ndarray, shape (p, p)
    noise_mm2 : float
        Variance that each reading adds.
    spread_mm2 : float
        Variance of a reading of nothing about the nominal length.
    """

    pairs: tuple[Leg, ...]
    length_mm: FloatArray
    covariance_mm2: FloatArray
    noise_mm2: float
    spread_mm2: float

    def index(self, leg: Leg) -> int:
        """Return the row of a pair.

        Parameters
        ----------
        leg : Leg

        Returns
        -------
        int

        Raises
        ------
        ConfigurationError
            Nothing is foreseen of the pair.
        """
        if leg not in self.pairs:
            raise ConfigurationError(f"The forecast of this pose has no ballbar length B{leg[0]} T{leg[1]}.")
        return self.pairs.index(leg)


def foreseen_by(forecast: PoseForecast, noise_mm2: float, spread_mm2: float) -> LengthForecast:
    """Return a forecast as arrays.

    Parameters
    ----------
    forecast : PoseForecast
        Of p pairs.
    noise_mm2 : float
        Variance that each reading adds.
    spread_mm2 : float
        Variance of a reading of nothing.

    Returns
    -------
    LengthForecast

    Raises
    ------
    ConfigurationError
        The covariance is not of the size of the forecast, not finite, or not one of real quantities.
    """
    length, covariance = np.array(forecast.length_mm), np.array(forecast.covariance_mm2)
    if covariance.shape != (len(length), len(length)) or len(forecast.legs) != len(length):
        raise ConfigurationError(
            f"The forecast of configuration {forecast.config} needs one length and one covariance row and "
            f"column for each of its {len(forecast.legs)} ballbar lengths."
        )
    finite = np.isfinite(length).all() and np.isfinite(covariance).all()
    # a little below 0 by rounding does no harm: the noise outweighs it at every scale
    if not finite or np.linalg.eigvalsh(covariance)[0] < -0.01 * noise_mm2:
        raise ConfigurationError(
            f"The forecast of configuration {forecast.config} must have finite lengths and a positive "
            "semi-definite covariance."
        )
    return LengthForecast(forecast.legs, length, covariance, noise_mm2, spread_mm2)


def nothing_foreseen(
    pairs: Sequence[Leg], nominal_mm: float, noise_mm2: float, spread_mm2: float
) -> LengthForecast:
    """Return what is known where no model foresees anything: all lengths are somewhere within the range.

    Parameters
    ----------
    pairs : sequence of Leg
    nominal_mm : float
        Of the ballbar.
    noise_mm2, spread_mm2 : float
        As of `foreseen_by`.

    Returns
    -------
    LengthForecast
    """
    count = len(pairs)
    return LengthForecast(
        tuple(pairs), np.full(count, nominal_mm), spread_mm2 * np.eye(count), noise_mm2, spread_mm2
    )


def log_likelihood(
    foreseen: LengthForecast, asked: Sequence[Leg], readings: Mapping[Leg, float], assignments: IntArray
) -> FloatArray:
    """Return the log-likelihood of the readings under each assignment.

    The density of the head of this module, mixed over the scales s of the forecast with their shares.

    Parameters
    ----------
    foreseen : LengthForecast
    asked : sequence of Leg
        What the k readings were asked for.
    readings : mapping of Leg to float
        Lengths [mm].
    assignments : ndarray of int, shape (m, k)
        Pairs (rows of `foreseen`) that the readings are of; the number of pairs stands for nothing.

    Returns
    -------
    ndarray, shape (m,)

    Raises
    ------
    ConfigurationError
        Nothing is foreseen of a pair that was asked for.
    """
    pairs, count = len(foreseen.pairs), len(asked)
    own = np.array([foreseen.index(leg) for leg in asked])
    # Nothing has a place of its own for every reading: two readings of nothing have nothing in common.
    place = np.where(assignments == pairs, pairs + np.arange(count), assignments)
    mean = np.concatenate([foreseen.length_mm, foreseen.length_mm[own]])
    misfit = np.array([readings[leg] for leg in asked]) - mean[place]
    variance = np.zeros((pairs + count, pairs + count))
    variance[pairs:, pairs:] = foreseen.spread_mm2 * np.eye(count)
    terms = []
    for scale, share in _SCALES:
        variance[:pairs, :pairs] = scale**2 * foreseen.covariance_mm2
        total = variance[place[:, :, None], place[:, None, :]] + foreseen.noise_mm2 * np.eye(count)
        terms.append(np.log(share) + _log_density(misfit, total))
    return np.asarray(np.logaddexp.reduce(terms, axis=0))


def _log_density(misfit: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the log-density of N(0, covariance) at each of m misfits (m, k)."""
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, misfit[..., None])[..., 0]
    logarithm = np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)
    density: FloatArray = (
        -0.5 * (white**2).sum(axis=1) - logarithm - 0.5 * misfit.shape[1] * np.log(2 * np.pi)
    )
    return density
