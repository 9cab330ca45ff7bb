"""What a person may have connected instead of what was asked, and how likely that is beforehand.

The figures are those of human reliability tables, for want of anybody who has counted slips with a ballbar.
They matter little where the evidence is clear; between, they say how soon a person is asked.

References
----------
A. D. Swain, H. E. Guttmann, Handbook of Human Reliability Analysis, NUREG/CR-1278, 1983: table 20-12,
selection among similar controls identified by labels only, 0.003; table 20-7, omission of an item of a short
list with check-off, 0.001; table 20-16, twice to five times that for a novice or under strain.
"""

from collections.abc import Sequence
from itertools import combinations, permutations, product

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray

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
    again = np.zeros((accounts, pairs + 1), dtype=bool)
    again[rows, taken[rows, readings]] = True
    odds += _OMISSION * again
    odds[:, pairs] = _NOTHING
    odds[:, own] = 1.0 - _SELECTION
    rows, readings = np.nonzero((taken == own) & (np.array(asked, dtype=np.int64) != own))
    odds[rows, own] = 1.0 - _FOLLOWED
    odds[rows, np.array(asked, dtype=np.int64)[readings]] = _FOLLOWED
    if affirmed:
        odds[:, np.arange(pairs + 1) != own] *= _REAFFIRMED
    return np.asarray(np.log(odds))


def _single(own: IntArray, pairs: int, questioned: bool) -> tuple[IntArray, FloatArray]:
    """Return all accounts in which one reading is of something else."""
    reading, instead = np.indices((len(own), pairs + 1)).reshape(2, -1)
    other = instead != own[reading]
    reading, instead = reading[other], instead[other]
    rows = np.tile(own, (len(reading), 1))
    rows[np.arange(len(reading)), reading] = instead
    again = (_SELECTION / _others(pairs) + _OMISSION) * (_REAFFIRMED if questioned else 1.0)
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
            row[list(chosen)] = own[[chosen[place] for place in order]]
            rows.append(row)
            odds.append(np.log(_SELECTION * _FOLLOWED) - (moved - 1) * np.log(_others(pairs)))
    return np.array(rows, dtype=np.int64).reshape(len(rows), count), np.array(odds)


def _others(pairs: int) -> int:
    return max(pairs - 1, _OTHERS)
