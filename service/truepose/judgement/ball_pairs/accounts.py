"""Accounts of all readings of a session so far: what each may be of, and what arm and cups would be then.

Before a pre-calibration there is no model that foresees lengths, but there is what the readings before say
of arm and cups. A wrong one among them would spoil that, so nothing rests on a single story: every account of
the readings that is still possible has a Kalman filter of its own, for every kind of arm that it may be. A
further reading makes of each account one for every pair that it may be of; those that fall far behind are
dropped. Where an early swap could not be seen, the account in which it happened goes on beside the other,
until later readings tell them apart.

References
----------
D. B. Reid, IEEE Trans. Automatic Control 24(6), 1979, 843-854: the same for tracks of targets.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import Leg
from truepose.domain.measurement.linear_lengths import ArmKind, StopLengths
from truepose.judgement.ball_pairs.slips import next_slips

_MOST: Final = 250  # accounts, each with a kind of arm
_FORGOTTEN: Final = float(np.log(1e-7))  # odds against the likeliest one below which an account is dropped
_OFF_MM: Final = 6.0  # a pair that is nominally further from a reading than that is not what was read


@dataclass(frozen=True, slots=True, eq=False)
class Accounts:
    """What the readings so far may be of; `begin` makes the first, `at` and `read` those that follow."""

    kinds: tuple[ArmKind, ...]
    noise_mm2: float  # variance of one reading
    nominal_mm: float  # of the ballbar
    range_mm: float  # either way, where it can read at all
    log_odds: FloatArray  # (m,) of which the exponentials add up to 1
    kind: IntArray  # (m,)
    mean: FloatArray  # (m, S + 6) of what is unknown of the session and of the tool at this stop
    covariance: FloatArray  # (m, S + 6, S + 6)
    taken: IntArray  # (m, readings) row of the pair at its stop; the number of pairs stands for nothing
    asked: tuple[int, ...] = ()  # rows of the pairs that were asked for, in the order of the readings
    stops: tuple[StopLengths, ...] = ()
    first: tuple[int, ...] = ()  # reading with which each stop begins
    foreseen_mm: float = float("nan")  # of the pair asked for last, before it was read

    @property
    def here(self) -> StopLengths:
        """The stop of the next reading."""
        return self.stops[-1]

    def at(self, stop: StopLengths) -> "Accounts":
        """Return the accounts at a further stop, nothing being read there yet."""
        known = self.mean.shape[1] - 6
        mean = np.zeros_like(self.mean)
        mean[:, :known] = self.mean[:, :known]
        covariance = np.zeros_like(self.covariance)
        covariance[:, :known, :known] = self.covariance[:, :known, :known]
        motion = np.array([kind.motion_mm for kind in self.kinds]) ** 2
        local = np.arange(known, known + 6)
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
        """
        stop, own = self.here, self.here.pairs.index(leg)
        pairs, first = len(stop.pairs), self.first[-1]
        slips = next_slips(own, pairs, self.asked[first:], self.taken[:, first:], affirmed=affirmed)
        far_mm = np.abs(stop.nominal_mm - length_mm)
        near = np.flatnonzero((far_mm < _OFF_MM) | (far_mm == far_mm.min()))  # one at least, however far
        slope = np.concatenate([stop.slope, stop.motion], axis=1)[near]  # (q, S + 6)
        shared = self.covariance @ slope.T  # (m, S + 6, q)
        variance = np.einsum("qs,msq->mq", slope, shared) + self.noise_mm2
        foreseen = stop.nominal_mm[near] + self.mean @ slope.T
        off = length_mm - foreseen
        fit = np.full((len(self.kind), pairs + 1), -np.inf)
        fit[:, near] = -0.5 * (off**2 / variance + np.log(2.0 * np.pi * variance))
        fit[:, pairs] = -np.log(2.0 * self.range_mm)
        odds = self.log_odds[:, None] + slips + fit
        account, pair = _likeliest(odds)
        weight = odds[account, pair]
        column = np.searchsorted(near, pair)
        named = pair < pairs
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
            foreseen_mm=self._foreseen(own),
        )

    def _foreseen(self, own: int) -> float:
        slope = np.concatenate([self.here.slope[own], self.here.motion[own]])
        return float(self.here.nominal_mm[own] + np.exp(self.log_odds) @ (self.mean @ slope))

    def forecast(self) -> tuple[FloatArray, FloatArray]:
        """Return mean (p,) and covariance (p, p) of the lengths at this stop, all accounts together [mm]."""
        slope = np.concatenate([self.here.slope, self.here.motion], axis=1)
        weight = np.exp(self.log_odds)
        each = self.mean @ slope.T
        mean = weight @ each
        spread = each - mean
        own = slope @ np.einsum("m,mij->ij", weight, self.covariance) @ slope.T
        return self.here.nominal_mm + mean, own + (weight[:, None] * spread).T @ spread

    def of_stop(self, stop: int) -> tuple[IntArray, FloatArray, IntArray]:
        """Return the accounts of one stop (n, k), their log odds (n,), and what was asked for (k,)."""
        end = self.first[stop + 1] if stop + 1 < len(self.first) else len(self.asked)
        own = np.array(self.asked[self.first[stop] : end], dtype=np.int64)
        distinct, number = np.unique(self.taken[:, self.first[stop] : end], axis=0, return_inverse=True)
        total = np.full(len(distinct), -np.inf)
        np.logaddexp.at(total, number.ravel(), self.log_odds)
        return distinct, total, own


def begin(kinds: Sequence[ArmKind], kit: BallbarKit) -> Accounts:
    """Return what is known before anything was read."""
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


def _likeliest(log_odds: FloatArray) -> tuple[IntArray, IntArray]:
    """Return account and pair of the entries that are worth following."""
    flat = log_odds.ravel()
    worth = np.flatnonzero(flat > flat.max() + _FORGOTTEN)
    if len(worth) > _MOST:
        worth = worth[np.argpartition(-flat[worth], _MOST)[:_MOST]]
    account, pair = np.unravel_index(worth, log_odds.shape)
    return account.astype(np.int64), pair.astype(np.int64)
