"""Whether a tracker is warm: how fast it still sees the fixed nests drift, by readings and not by a clock.

A tracker that warms up bends and turns a little, so that nests that stand still seem to move. What that
does to a session is what the nests move between two looks at them. The line through the last rounds of
readings says how much that is, and their scatter how well that is known.

With p_kn the place of nest n of N in round k of K at the time t_kn, both less their means over the rounds:

    rate_n = sum_k t_kn p_kn / sum_k t_kn^2                least squares, by axis
    s^2    = sum |p_kn - t_kn rate_n|^2 / (3 N (K - 2))    variance of a coordinate, the same for all nests
    ahead  = T max_n |rate_n|                              T = 300 s
    bound  = T max_n (|rate_n| + 2 s / sqrt(sum_k t_kn^2))
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.session import FixedNestTaken, SessionPlan

AHEAD_S: Final = 300.0  # between two looks at the fixed nests: ten stops of half a minute
_FEWEST: Final = 8  # rounds; a line through fewer is known too badly for its uncertainty to be believed
_SHARE_OF_LIMIT: Final = 0.1  # of what makes a session pause, that the tracker may add by itself
_SURE: Final = 2.0  # standard uncertainties: 95 % along the direction of the drift


@dataclass(frozen=True, slots=True)
class Warmth:
    """How warm a tracker is, by what it read of the fixed nests."""

    time_s: tuple[float, ...]  # of each round, since the first
    drift_mm: tuple[float, ...]  # mean way of the nests since the first round, its norm
    ahead_mm: float | None  # that the nest which drifts most will drift in `AHEAD_S`; None: too few rounds
    bound_mm: float | None  # below which that is, with 95 %
    allowed_mm: float

    @property
    def ready(self) -> bool:
        """Whether the tracker drifts no more than is allowed, with 95 %."""
        return self.bound_mm is not None and self.bound_mm <= self.allowed_mm


def warmth(taken: Sequence[FixedNestTaken], plan: SessionPlan, n_fixed_nests: int) -> Warmth:
    """Return how warm a tracker is after these readings, oldest first; a round that was cut counts not."""
    allowed_mm = _SHARE_OF_LIMIT * plan.reference_limit_mm
    rounds = _whole_rounds(taken, n_fixed_nests)
    if not rounds:
        return Warmth((), (), None, None, allowed_mm)
    times = np.array([[one.time_s for one in each] for each in rounds])
    places = np.array([[one.position_tracker_mm for one in each] for each in rounds])
    drift = np.linalg.norm((places - places[0]).mean(axis=1), axis=1)
    newest = max(_FEWEST, len(rounds) // 2)  # half of them say how fast it drifts now
    ahead = _ahead(times[-newest:], places[-newest:])
    since = times.mean(axis=1) - times[0].mean()
    return Warmth(tuple(since.tolist()), tuple(drift.tolist()), *ahead, allowed_mm)


def _whole_rounds(taken: Sequence[FixedNestTaken], n_fixed_nests: int) -> list[list[FixedNestTaken]]:
    """Return the rounds in which every nest was read; one that was broken off began again with the first."""
    rounds: list[list[FixedNestTaken]] = []
    for one in taken:
        if one.fixed_nest == 1:
            rounds.append([])
        if rounds:
            rounds[-1].append(one)
    return [each for each in rounds if len(each) == n_fixed_nests]


def _ahead(times_s: FloatArray, places_mm: FloatArray) -> tuple[float | None, float | None]:
    """Extrapolate a line through the last rounds.

    Parameters
    ----------
    times_s : ndarray, shape (k, n)
        When each of n nests was read in each of k rounds [s].
    places_mm : ndarray, shape (k, n, 3)
        Where it was read, in the tracker's frame [mm].

    Returns
    -------
    ahead_mm, bound_mm : float or None
        Drift of the worst nest in `AHEAD_S`, and what it stays below with 95 % [mm]; None before there are
        enough rounds.
    """
    rounds, nests, _ = places_mm.shape
    if rounds < _FEWEST:
        return None, None
    # By nest: each is read at another moment of its round.
    since = times_s - times_s.mean(axis=0)
    spread = np.sum(since**2, axis=0)
    moved = places_mm - places_mm.mean(axis=0)
    rates = np.einsum("kn,knx->nx", since, moved) / spread[:, None]
    left = moved - since[..., None] * rates
    # Over all nests and axes together: eight rounds of one nest tell a scatter badly.
    scatter = np.sqrt(np.sum(left**2) / (3 * nests * (rounds - 2)))
    ahead = np.linalg.norm(rates, axis=1) * AHEAD_S
    return float(ahead.max()), float((ahead + _SURE * scatter / np.sqrt(spread) * AHEAD_S).max())
