"""Whether a reading goes with its pair while no model foresees lengths: judged by all accounts of a session.

A pair that was read already at the same stop is asked about where it has two hundredths of the probability
of what was asked: nothing shows later that it was read twice. Other pairs and whole poses are asked about at
a tenth. A pair that was read for another one comes itself, and then agrees with what it was taken for; and
the pre-calibration looks at all poses once more, when it knows ten times as much.
"""

from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.ballbar import Leg, Suspicion, SuspicionKind
from truepose.domain.measurement.linear_lengths import TOLD_APART
from truepose.judgement.ball_pairs.accounts import Accounts

_AGAIN: Final = float(np.log(0.02))  # odds above which a person is asked whether a pair is read twice
_OTHER: Final = float(np.log(0.1))  # ... whether it is another pair, or the pose is not as asked
_NEAR_MM: Final = 3.0  # a pair that is nominally further off the ballbar's length cannot be connected


def judge_early(after: Accounts, length_mm: float, *, complete: bool) -> Suspicion | None:
    """Judge the last reading by everything that was read before.

    Parameters
    ----------
    after : Accounts
        With the reading.
    length_mm : float
    complete : bool
        It is the last one of its pose: then those before it at the same stop are judged once more.

    Returns
    -------
    Suspicion or None
        None: the reading goes with what was asked, as far as anybody can tell.
    """
    taken, odds, asked = after.of_stop(len(after.stops) - 1)
    right = taken[:, -1] == asked[-1]
    best, best_odds = _likeliest(taken[~right], odds[~right])
    if best is not None and best_odds >= _threshold(best, asked, after) + _total(odds[right]):
        return _suspicion(after, best, asked, len(asked) - 1, length_mm)
    as_asked = (taken == asked).all(axis=1)
    if not complete or as_asked.all():
        return None
    other = int(np.argmax(np.where(as_asked, -np.inf, odds)))
    if odds[other] < _OTHER + _total(odds[as_asked]):
        return None
    wrong = int(np.flatnonzero(taken[other] != asked)[-1])
    return _suspicion(after, taken[other], asked, wrong, length_mm)


def refuted_stops(accounts: Accounts) -> tuple[int, ...]:
    """Return the stops, counted from 0, of which another account is likelier by now than what was asked."""
    found = []
    for stop in range(len(accounts.stops)):
        taken, odds, asked = accounts.of_stop(stop)
        as_asked = (taken == asked).all(axis=1)
        if not as_asked.all() and odds[~as_asked].max() > _total(odds[as_asked]):
            found.append(stop)
    return tuple(found)


def alike(here: Accounts) -> tuple[tuple[Leg, Leg], ...]:
    """Return the pairs at the present stop whose lengths cannot be told apart.

    To exchange them does not show. Only pairs that the ballbar can be put between are looked at.
    """
    length, covariance = here.forecast()
    pairs = here.here.pairs
    shown = [row for row in range(len(pairs)) if _is_shown(here, row)]
    close = indistinct(length[shown], covariance[np.ix_(shown, shown)], here.noise_mm2)
    return tuple((pairs[shown[a]], pairs[shown[b]]) for a, b in close)


def indistinct(
    length_mm: FloatArray, covariance_mm2: FloatArray, noise_mm2: float
) -> tuple[tuple[int, int], ...]:
    """Return which two of n foreseen lengths are closer than their difference is foreseen."""
    variance = np.diag(covariance_mm2)
    unsure = variance[:, None] + variance - 2.0 * covariance_mm2 + 2.0 * noise_mm2
    close = (length_mm[:, None] - length_mm) ** 2 < TOLD_APART**2 * unsure
    return tuple((a, b) for a, b in combinations(range(len(length_mm)), 2) if close[a, b])


def _is_shown(here: Accounts, row: int) -> bool:
    return bool(abs(here.here.nominal_mm[row] - here.nominal_mm) < _NEAR_MM)


def _threshold(account: IntArray, asked: IntArray, after: Accounts) -> float:
    kind = _kind(account, asked, int(account[-1]), len(after.here.pairs))
    return _AGAIN if kind == "same_pair" else _OTHER


def _total(log_odds: FloatArray) -> float:
    return float(np.logaddexp.reduce(log_odds)) if len(log_odds) else -np.inf


def _likeliest(taken: IntArray, odds: FloatArray) -> tuple[IntArray | None, float]:
    """Return the best account of those that name the likeliest pair for the last reading, and its odds."""
    if not len(taken):
        return None, -np.inf
    named = np.unique(taken[:, -1])
    shares = [_total(odds[taken[:, -1] == pair]) for pair in named]
    number = int(np.argmax(shares))
    chosen = taken[:, -1] == named[number]
    return taken[chosen][int(np.argmax(odds[chosen]))], shares[number]


def _suspicion(
    after: Accounts, account: IntArray, asked: IntArray, reading: int, length_mm: float
) -> Suspicion:
    pairs = after.here.pairs
    instead = int(account[reading])
    suspected = pairs[instead] if instead < len(pairs) else None
    return Suspicion(
        _kind(account, asked, instead, len(pairs)),
        pairs[int(asked[reading])],
        suspected,
        length_mm,
        after.foreseen_mm if reading == len(asked) - 1 else None,
    )


def _kind(account: IntArray, asked: IntArray, instead: int, pairs: int) -> SuspicionKind:
    if instead == pairs:
        return "unlikely"
    own = np.flatnonzero(asked == instead)
    if not len(own):
        return "other_pair"
    return "same_pair" if account[own[0]] == instead else "exchanged"
