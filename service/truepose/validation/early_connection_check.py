"""Whether a reading goes with its pair while no model predicts lengths: by all accounts of a session.

An account says what each reading so far is of, and what arm and cups would be then. Before a pre-calibration
there is no model that foresees lengths, but there is what the readings before say of arm and cups. A wrong
one among them would spoil that, so nothing rests on a single story: every account of the readings that is
still possible has a Kalman filter of its own, for every kind of arm that it may be. A further reading makes
of each account one for every pair that it may be of; those that fall far behind are dropped. Where an early
swap could not be seen, the account in which it happened goes on beside the other, until later readings tell
them apart (decision 0025).

With x ~ N(m, P) what an account knows and h the slope of a pair, a length y is predicted as l + h m with the
variance s = h P h^T + r. Read, it weighs the account by its density there, and m += k (y - l - h m),
P -= k (h P) with k = P h^T / s. A reading of nothing has the density 1 / (2 range) and teaches nothing.

A pair that was read already at the same stop is asked about where it has two hundredths of the probability of
what was asked: nothing shows later that it was read twice. Other pairs and whole poses are asked about at a
tenth. A pair that was read for another one comes itself, and then agrees with what it was taken for; and the
pre-calibration looks at all poses once more, when it knows ten times as much.

References
----------
D. B. Reid, IEEE Trans. Automatic Control 24(6), 1979, 843-854: the same for tracks of targets.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import TOLD_APART, ArmKind, Leg, StopLengths, Suspicion
from truepose.domain.cell import BallbarKit
from truepose.validation.misconnections import likeliest, next_slips, slip_kind, total

# With so many a reading costs milliseconds (decision 0025).
_MOST: Final = 250  # accounts, each with a kind of arm
_FORGOTTEN: Final = float(np.log(1e-7))  # odds against the likeliest one below which an account is dropped
_OFF_MM: Final = 6.0  # a pair that is nominally further from a reading than that is not what was read


@dataclass(frozen=True, slots=True, eq=False)
class Accounts:
    """What the readings so far may be of; `begin` makes the first, `at` and `read` those that follow.

    Nothing is remembered elsewhere: the accounts follow from plan and ledger, and are made again from them.

    Attributes
    ----------
    kinds : tuple of ArmKind
    noise_mm2 : float
        Variance of one reading.
    nominal_mm : float
        Of the ballbar.
    range_mm : float
        Either way, where it can read at all.
    log_odds : ndarray, shape (m,)
        Of which the exponentials add up to 1.
    kind : ndarray of int, shape (m,)
        Of arm.
    mean : ndarray, shape (m, S + 6)
        Of what is unknown of the session and of the tool at this stop.
    covariance : ndarray, shape (m, S + 6, S + 6)
    taken : ndarray of int, shape (m, readings)
        Row of the pair at its stop; the number of pairs stands for nothing.
    asked : tuple of int
        Rows of the pairs that were asked for, in the order of the readings.
    lengths_mm : tuple of float
        What was read for them.
    stops : tuple of StopLengths
    first : tuple of int
        Reading with which each stop begins.
    foreseen_mm : float
        Of the pair asked for last, before it was read.
    """

    kinds: tuple[ArmKind, ...]
    noise_mm2: float
    nominal_mm: float
    range_mm: float
    log_odds: FloatArray
    kind: IntArray
    mean: FloatArray
    covariance: FloatArray
    taken: IntArray
    asked: tuple[int, ...] = ()
    lengths_mm: tuple[float, ...] = ()
    stops: tuple[StopLengths, ...] = ()
    first: tuple[int, ...] = ()
    foreseen_mm: float = float("nan")

    @property
    def here(self) -> StopLengths:
        """The stop of the next reading."""
        return self.stops[-1]

    def at(self, stop: StopLengths) -> "Accounts":
        """Return the accounts at a further stop, nothing being read there yet.

        Parameters
        ----------
        stop : StopLengths

        Returns
        -------
        Accounts
            What is known of the session stays; how the tool came to rest at this stop is unknown.
        """
        known = self.mean.shape[1] - 6
        mean = np.zeros_like(self.mean)
        mean[:, :known] = self.mean[:, :known]
        covariance = np.zeros_like(self.covariance)
        covariance[:, :known, :known] = self.covariance[:, :known, :known]
        motion = np.array([kind.motion_mm for kind in self.kinds]) ** 2
        local = np.arange(known, known + 6)
        # Where the tool comes to rest is drawn anew at each stop; nothing of it is known from the stops
        # before.
        covariance[:, local, local] = motion[self.kind][:, None]
        return replace(
            self,
            mean=mean,
            covariance=covariance,
            stops=(*self.stops, stop),
            first=(*self.first, len(self.asked)),
        )

    def read(self, leg: Leg, length_mm: float, *, affirmed: bool = False) -> "Accounts":
        """Return the accounts once a length was read for a pair.

        Parameters
        ----------
        leg : Leg
            The pair that was asked for.
        length_mm : float
        affirmed : bool
            A person was asked about it, and maintained that it is of that pair.

        Returns
        -------
        Accounts
            At most 250, the likeliest; none below 1e-7 of the likeliest.
        """
        stop, own = self.here, self.here.pairs.index(leg)
        pairs, first = len(stop.pairs), self.first[-1]
        slips = next_slips(own, pairs, self.asked[first:], self.taken[:, first:], affirmed=affirmed)
        far_mm = np.abs(stop.nominal_mm - length_mm)
        # Pairs that are no legs are centimetres away. They could never be what was read, and need no column
        # each.
        near = np.flatnonzero((far_mm < _OFF_MM) | (far_mm == far_mm.min()))  # one at least, however far
        slope = np.concatenate([stop.slope, stop.motion], axis=1)[near]  # (q, S + 6)
        shared = self.covariance @ slope.T  # (m, S + 6, q)
        variance = np.einsum("qs,msq->mq", slope, shared) + self.noise_mm2
        foreseen = stop.nominal_mm[near] + self.mean @ slope.T
        off = length_mm - foreseen
        fit = np.full((len(self.kind), pairs + 1), -np.inf)
        fit[:, near] = -0.5 * (off**2 / variance + np.log(2.0 * np.pi * variance))
        # A reading of no pair may be anywhere in the range, with equal density.
        fit[:, pairs] = -np.log(2.0 * self.range_mm)
        odds = self.log_odds[:, None] + slips + fit
        account, pair = _likeliest_pairs(odds)
        weight = odds[account, pair]
        column = np.searchsorted(near, pair)
        named = pair < pairs
        # Any column will do: its gain is 0, since nothing is learnt from a reading of nothing.
        column[~named] = 0
        covariance, mean = self.covariance[account], self.mean[account]
        gain = shared[account, :, column] * (named / variance[account, column])[:, None]
        covariance -= gain[:, :, None] * shared[account, :, column][:, None, :]
        mean += gain * off[account, column][:, None]
        return replace(
            self,
            log_odds=weight - np.logaddexp.reduce(weight),
            kind=self.kind[account],
            mean=mean,
            covariance=covariance,
            taken=np.concatenate([self.taken[account], pair[:, None]], axis=1),
            asked=(*self.asked, own),
            lengths_mm=(*self.lengths_mm, length_mm),
            # From the accounts before the reading; those after it have adapted to it.
            foreseen_mm=self._foreseen(own),
        )

    def _foreseen(self, own: int) -> float:
        """Return the length of a pair [mm] as all accounts together predict it."""
        slope = np.concatenate([self.here.slope[own], self.here.motion[own]])
        return float(self.here.nominal_mm[own] + np.exp(self.log_odds) @ (self.mean @ slope))

    def forecast(self) -> tuple[FloatArray, FloatArray]:
        """Return the lengths at this stop as all accounts together predict them.

        Mean and covariance of the mixture: those within the accounts, and the spread of their means.

        Returns
        -------
        mean_mm : ndarray, shape (p,)
        covariance_mm2 : ndarray, shape (p, p)
        """
        slope = np.concatenate([self.here.slope, self.here.motion], axis=1)
        weight = np.exp(self.log_odds)
        each = self.mean @ slope.T
        mean = weight @ each
        spread = each - mean
        own = slope @ np.einsum("m,mij->ij", weight, self.covariance) @ slope.T
        return self.here.nominal_mm + mean, own + (weight[:, None] * spread).T @ spread

    def of_stop(self, stop: int) -> tuple[IntArray, FloatArray, IntArray]:
        """Return the accounts of one stop, those that differ elsewhere only taken together.

        Parameters
        ----------
        stop : int
            From 0.

        Returns
        -------
        taken : ndarray of int, shape (n, k)
            Rows of the pairs that its readings are of.
        log_odds : ndarray, shape (n,)
        asked : ndarray of int, shape (k,)
        """
        end = self.first[stop + 1] if stop + 1 < len(self.first) else len(self.asked)
        own = np.array(self.asked[self.first[stop] : end], dtype=np.int64)
        distinct, number = np.unique(self.taken[:, self.first[stop] : end], axis=0, return_inverse=True)
        log_odds = np.full(len(distinct), -np.inf)
        np.logaddexp.at(log_odds, number.ravel(), self.log_odds)
        return distinct, log_odds, own


def begin(kinds: Sequence[ArmKind], kit: BallbarKit) -> Accounts:
    """Return what is known before anything was read.

    Parameters
    ----------
    kinds : sequence of ArmKind
        At least one, with the same unknowns.
    kit : BallbarKit

    Returns
    -------
    Accounts
        One a kind of arm, at no stop yet.
    """
    unknowns = len(kinds[0].mean)
    mean = np.zeros((len(kinds), unknowns + 6))
    covariance = np.zeros((len(kinds), unknowns + 6, unknowns + 6))
    for number, kind in enumerate(kinds):
        mean[number, :unknowns] = kind.mean
        covariance[number, :unknowns, :unknowns] = kind.covariance
    shares = np.log([kind.share for kind in kinds])
    return Accounts(
        tuple(kinds),
        kit.reading_u_mm**2 + kit.zero_u_mm**2,
        kit.base_bars.nominal_mm,
        kit.range_mm,
        shares - np.logaddexp.reduce(shares),
        np.arange(len(kinds), dtype=np.int64),
        mean,
        covariance,
        np.zeros((len(kinds), 0), dtype=np.int64),
    )


def _likeliest_pairs(log_odds: FloatArray) -> tuple[IntArray, IntArray]:
    """Return account and pair of the entries that are worth following."""
    flat = log_odds.ravel()
    worth = np.flatnonzero(flat > flat.max() + _FORGOTTEN)
    if len(worth) > _MOST:
        worth = worth[np.argpartition(-flat[worth], _MOST)[:_MOST]]
    account, pair = np.unravel_index(worth, log_odds.shape)
    return account.astype(np.int64), pair.astype(np.int64)


# Two thresholds, since one does not do: at 0.01 four right readings in a hundred of an everyday robot were
# questioned, at 0.1 one in ten pairs read twice was missed (decision 0025).
_AGAIN: Final = float(np.log(0.02))  # odds above which a person is asked whether a pair is read twice
_OTHER: Final = float(np.log(0.1))  # ... whether it is another pair, or the pose is not as asked
_ARM_MM: Final = 2.0  # a pair that is nominally further out of the ballbar's range cannot be connected


def judge_early(after: Accounts, *, complete: bool) -> Suspicion | None:
    """Judge the last reading by everything that was read before.

    Parameters
    ----------
    after : Accounts
        With the reading.
    complete : bool
        It is the last one of its pose: then those before it at the same stop are judged once more.

    Returns
    -------
    Suspicion or None
        None: the reading goes with what was asked, as far as anybody can tell.
    """
    taken, odds, asked = after.of_stop(len(after.stops) - 1)
    right = taken[:, -1] == asked[-1]
    best, best_odds = likeliest(taken[~right], odds[~right])
    if best is not None and best_odds >= _threshold(best, asked, after) + total(odds[right]):
        return _suspicion(after, best, asked, len(asked) - 1)
    as_asked = (taken == asked).all(axis=1)
    if not complete or as_asked.all():
        return None
    other = int(np.argmax(np.where(as_asked, -np.inf, odds)))
    if odds[other] < _OTHER + total(odds[as_asked]):
        return None
    wrong = int(np.flatnonzero(taken[other] != asked)[-1])
    return _suspicion(after, taken[other], asked, wrong)


def refuted_stops(accounts: Accounts) -> tuple[int, ...]:
    """Return the stops of which another account is likelier by now than what was asked.

    Parameters
    ----------
    accounts : Accounts

    Returns
    -------
    tuple of int
        Counted from 0.
    """
    found = []
    for stop in range(len(accounts.stops)):
        taken, odds, asked = accounts.of_stop(stop)
        as_asked = (taken == asked).all(axis=1)
        if not as_asked.all() and odds[~as_asked].max() > total(odds[as_asked]):
            found.append(stop)
    return tuple(found)


def alike(here: Accounts) -> tuple[tuple[Leg, Leg], ...]:
    """Return the pairs at the present stop whose lengths cannot be told apart.

    To exchange them does not show. Only pairs that the ballbar can be put between are looked at.

    Parameters
    ----------
    here : Accounts

    Returns
    -------
    tuple of (Leg, Leg)
    """
    length, covariance = here.forecast()
    pairs = here.here.pairs
    shown = [row for row in range(len(pairs)) if _is_shown(here, row)]
    close = indistinct(length[shown], covariance[np.ix_(shown, shown)], here.noise_mm2)
    return tuple((pairs[shown[a]], pairs[shown[b]]) for a, b in close)


def indistinct(
    length_mm: FloatArray, covariance_mm2: FloatArray, noise_mm2: float
) -> tuple[tuple[int, int], ...]:
    """Return which two of n predicted lengths cannot be told apart by their difference.

    Those with (l_a - l_b)^2 < 9 (V_aa + V_bb - 2 V_ab + 2 r), r the variance of a reading.

    Parameters
    ----------
    length_mm : ndarray, shape (n,)
    covariance_mm2 : ndarray, shape (n, n)
    noise_mm2 : float

    Returns
    -------
    tuple of (int, int)
    """
    variance = np.diag(covariance_mm2)
    unsure = variance[:, None] + variance - 2.0 * covariance_mm2 + 2.0 * noise_mm2
    close = (length_mm[:, None] - length_mm) ** 2 < TOLD_APART**2 * unsure
    return tuple((a, b) for a, b in combinations(range(len(length_mm)), 2) if close[a, b])


def _is_shown(here: Accounts, row: int) -> bool:
    """Whether the ballbar can be put between a pair at all."""
    return bool(abs(here.here.nominal_mm[row] - here.nominal_mm) < here.range_mm + _ARM_MM)


def _threshold(account: IntArray, asked: IntArray, after: Accounts) -> float:
    """Return the log odds above which the person is prompted about the last reading."""
    kind = slip_kind(account, asked, int(account[-1]), len(after.here.pairs))
    return _AGAIN if kind == "same_pair" else _OTHER


def _suspicion(after: Accounts, account: IntArray, asked: IntArray, reading: int) -> Suspicion:
    """Return the suspicion that an account raises about one reading of the present stop."""
    pairs = after.here.pairs
    instead = int(account[reading])
    suspected = pairs[instead] if instead < len(pairs) else None
    return Suspicion(
        slip_kind(account, asked, instead, len(pairs)),
        pairs[int(asked[reading])],
        suspected,
        after.lengths_mm[after.first[-1] + reading],
        after.foreseen_mm if reading == len(asked) - 1 else None,
    )
