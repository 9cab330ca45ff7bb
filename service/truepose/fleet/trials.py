r"""How well each change over time would explain what is left of a fleet: likelihood ratios and chances.

A change adds f_c E v to campaigns c, with shape f and directions E. With x the parameters that the model of
the fleet puts at each campaign, and everything else integrated out,

    U = E' sum f_c (b_c - A_c x_c)                                  score
    F = E' (sum f_c^2 A_c - what deviations and g take up) E        its covariance where nothing changed

U' F^-1 U is then chi-square with q degrees of freedom. A random v ~ N(0, s I) of unknown size s has twice the
log likelihood ratio, largest over s >= 0 and 0 where nothing speaks for it (the boundary),

    max_s sum_k [z_k^2 s l_k / (1 + s l_k) - ln(1 + s l_k)]         F = V l V', z = l^-1/2 V' U

An instrument's scale is judged otherwise (`instrument_scales`).

References
----------
S. G. Self, K.-Y. Liang, J. American Statistical Association 82, 1987, 605-610 (tests on the boundary).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.fleet.causes import AgeingCause
from truepose.fleet.mixed_model import NamedChange, Posterior
from truepose.identification.distributions import chi2_exceeded, chi2_median

Scope = Literal["robot", "type", "instrument"]
Kind = Literal["linear", "step", "day"]
_MOST_BEGINNINGS: Final = 12  # of lines
_SEEN: Final = 1e-6  # of the largest information of a cause: directions with less are not seen at all
_SIZES: Final = np.logspace(-4.0, 8.0, 121)  # of 1 / information: where the largest ratio is looked for


@dataclass(frozen=True)
class Change:
    """A change that may have happened.

    Attributes
    ----------
    scope : str
        "robot", "type" or "instrument".
    of : str
        Robot or instrument; empty for the type.
    cause : AgeingCause
    kind : str
        "linear", "step" or "day".
    since : float
        Day: of a line the last without it, of a step the first with it.
    shape : ndarray, shape (C,)
        0 before, 1 at the end.
    """

    scope: Scope
    of: str
    cause: AgeingCause
    kind: Kind
    since: float
    shape: FloatArray

    def beside(self, other: "Change") -> bool:
        """Return whether both are of the same robot, or the type, over the same campaigns, by any cause."""
        mine, its = ((one.scope, one.of, one.kind, one.since) for one in (self, other))
        return mine == its

    def grows_as(self, other: "Change") -> bool:
        """Return whether both are even growth of the same cause, whenever it began."""
        return self.key[:-1] == other.key[:-1] and self.kind == "linear"

    def is_of(self, whose: str, cause: AgeingCause) -> bool:
        """Return whether it is a change of a robot, instrument or, empty, the type by some cause."""
        return (self.of, self.cause.key) == (whose, cause.key)

    def same_as(self, other: "Change") -> bool:
        """Return whether both are the same change."""
        return self.key == other.key

    @property
    def key(self) -> tuple[str | float, ...]:
        """What tells it from every other change."""
        return (self.scope, self.of, *self.cause.key, self.kind, self.since)


@dataclass(frozen=True, slots=True)
class Trial:
    """What speaks for a change.

    Attributes
    ----------
    change : Change
    ratio : float
        Twice the log likelihood ratio.
    chance : float
        Of so much where nothing changed, 0 to 1.
    excess : float
        By which variances of this cause exceed what the readings state.
    squares : float
        Chi-square where nothing changed; 0 of an instrument, which is judged by F.
    degrees : int
        Its degrees of freedom.
    variance : float
        Of its size once it is in the model, before any reading, in squared stated widths.
    """

    change: Change
    ratio: float
    chance: float
    excess: float = 1.0
    squares: float = 0.0
    degrees: int = 0
    variance: float = 1.0

    @property
    def named(self) -> NamedChange:
        """As a part of the model."""
        return NamedChange(self.change.cause.directions, self.change.shape, self.variance)

    def chance_beside(self, others: Sequence["Trial"]) -> float:
        """Return the chance of so much where other causes scatter over the same campaigns as they do.

        A campaign whose fit took its readings for better than they were scatters in everything; the median of
        what other causes show tells by how much.

        Parameters
        ----------
        others : sequence of Trial
            Of other causes, over the same campaigns.

        Returns
        -------
        float
            0 to 1.
        """
        seen = [one.squares / chi2_median(float(one.degrees)) for one in others if one.degrees]
        # Never less than stated: others that happen to be quiet make this change no more certain.
        scatter = max(1.0, float(np.median(seen))) if seen else 1.0
        return chi2_exceeded(self.squares / scatter, float(self.degrees)) if self.degrees else 1.0


def shapes(day: FloatArray, among: BoolArray) -> Iterator[tuple[Kind, float, FloatArray]]:
    """Yield kind, first day and shape (C,) of the ways in which something may change over some campaigns.

    Evenly since the first day or a later one, at once, or on a single day between others. Since the last day
    but one evenly is at once on the last.

    Parameters
    ----------
    day : ndarray, shape (C,)
    among : ndarray of bool, shape (C,)
        Campaigns that it concerns.

    Yields
    ------
    kind : str
    since : float
        First day.
    shape : ndarray, shape (C,)
        0 before and at all other campaigns, 1 at the end.
    """
    known = np.unique(day[among])
    for at in _spread(known[:-2]).tolist():
        yield "linear", at, among * np.maximum(day - at, 0.0) / (known[-1] - at)
    for at in known[1:].tolist():
        yield "step", at, (among & (day >= at)).astype(float)
    for at in known[1:-1].tolist():
        yield "day", at, (among & (day == at)).astype(float)


def _spread(days: FloatArray) -> FloatArray:
    """Return the first of days and so many others, evenly among them: of neighbours no two lines differ."""
    at = np.linspace(0.0, len(days) - 1.0, min(len(days), _MOST_BEGINNINGS))
    return days[np.round(at).astype(np.int64)]


class Score:
    """Score and information of all directions for one shape over the campaigns.

        U = sum f_c (b_c - A_c x_c)
        F = sum f_c^2 A_c - sum_i m_i' D_i m_i - k C k'     m_i = sum over its campaigns f_c A_c,
                                                            k = sum f_c A_c L_c - sum m_i' D_i X_i

    Parameters
    ----------
    posterior : Posterior
        With the changes that are named already.
    shape : ndarray, shape (C,)
        f.

    Attributes
    ----------
    score : ndarray, shape (P + 1,)
        U.
    information : ndarray, shape (P + 1, P + 1)
        F.
    """

    def __init__(self, posterior: Posterior, shape: FloatArray) -> None:
        equations = posterior.equations
        fleet, here = equations.fleet, np.flatnonzero(shape)
        f, p = shape[here], equations.parameters
        normal = fleet.normal[here]
        left = fleet.right[here] - np.einsum("cpq,cq->cp", normal, posterior.fitted[here])
        self.score = f @ left  # (P + 1,)
        information = np.einsum("c,cpq->pq", f**2, normal)
        common = np.einsum("c,cpg->gp", f, equations.seen[here])
        for robot in np.unique(fleet.robot[here]).tolist():
            own = fleet.robot[here] == robot
            mine = np.einsum("c,cpq->pq", f[own], normal[own, :p])  # (P, P + 1)
            information -= mine.T @ posterior.own[robot] @ mine
            common -= posterior.gain[robot].T @ mine
        self.information = information - common.T @ posterior.covariance @ common

    def of(self, directions: FloatArray) -> "Evidence":
        """Return what is seen of a change along directions.

        Parameters
        ----------
        directions : ndarray, shape (P + 1, q)
            In stated widths, the scale last.

        Returns
        -------
        Evidence
        """
        return seen_of(directions.T @ self.score, directions.T @ self.information @ directions)


class Evidence(NamedTuple):
    """A change as far as it is seen, along the axes of its information.

    Attributes
    ----------
    squares : ndarray, shape (q,)
        Scores over their standard deviations, squared.
    information : ndarray, shape (q,)
        Positive.
    """

    squares: FloatArray
    information: FloatArray

    def judged(self, excess: float = 1.0) -> tuple[float, float]:
        """Return how much speaks for a change, and the chance of so much.

        Parameters
        ----------
        excess : float
            By which the variance of such scores exceeds what the readings state.

        Returns
        -------
        ratio : float
            Twice the log likelihood ratio.
        chance : float
            Where nothing changed; 1 where nothing is seen.
        """
        if not len(self.squares):
            return 0.0, 1.0
        squares = self.squares / excess
        return largest_ratio(squares, self.information / excess), chi2_exceeded(
            float(squares.sum()), float(len(squares))
        )

    def likeliest_variance(self, excess: float) -> float:
        """Return the variance of a change's size at which most speaks for it.

        Parameters
        ----------
        excess : float
            As of `judged`.

        Returns
        -------
        float
            In squared stated widths; that of the smallest size that is tried where nothing is seen.
        """
        if not len(self.squares):
            return 0.0
        sizes = _SIZES * excess / float(self.information.max())
        return float(sizes[np.argmax(_ratios(self.squares / excess, self.information / excess))])

    def scattered(self, excess: float) -> float:
        """Return twice the log likelihood ratio of readings that are alike worse than they were taken for.

        Of q squares with mean m the largest over the ratio of variances, q (m - 1 - ln m), is at m.

        Parameters
        ----------
        excess : float
            As of `judged`.

        Returns
        -------
        float
            0 where they scatter no more than that.
        """
        mean = float(self.squares.mean()) / excess if len(self.squares) else 0.0
        return len(self.squares) * (mean - 1.0 - float(np.log(mean))) if mean > 1.0 else 0.0

    def trial(self, change: Change, excess: float) -> Trial:
        """Return what speaks for a change that is seen so.

        Parameters
        ----------
        change : Change
        excess : float
            As of `judged`.

        Returns
        -------
        Trial
        """
        return Trial(
            change,
            *self.judged(excess),
            excess,
            float(self.squares.sum()) / excess,
            len(self.squares),
        )


def seen_of(score: FloatArray, information: FloatArray) -> Evidence:
    """Return what a score and its information say along the directions that are seen.

    Parameters
    ----------
    score : ndarray, shape (q,)
    information : ndarray, shape (q, q)
        Its covariance where nothing changed.

    Returns
    -------
    Evidence
        Of r <= q directions: those whose information is more than a millionth of the largest.
    """
    values, vectors = np.linalg.eigh(information)
    seen = values > max(_SEEN * float(values[-1]), 1e-300)
    return Evidence((vectors[:, seen].T @ score) ** 2 / values[seen], values[seen])


def excess_of(seen: Sequence[Evidence]) -> float:
    """Return by which the scores of one cause scatter beyond what is stated, 1 where they do not.

    The median over many robots and shapes against that of chi-square: a few robots that age do not move it.
    Readings that state one figure for all directions, as most do, are worse than that across a tracker's beam
    and better along it; so each cause has its own.

    Parameters
    ----------
    seen : sequence of Evidence
        Of one cause, over all robots and shapes.

    Returns
    -------
    float
        Of variances, 1 or more.
    """
    each = [
        float(one.squares.sum()) / chi2_median(float(len(one.squares))) for one in seen if len(one.squares)
    ]
    return max(1.0, float(np.median(each))) if each else 1.0


def largest_ratio(squares: FloatArray, information: FloatArray) -> float:
    """Return twice the log likelihood ratio, largest over the size of the change.

    Parameters
    ----------
    squares : ndarray, shape (q,)
        Squared scores over their variance.
    information : ndarray, shape (q,)
        Positive.

    Returns
    -------
    float
        0 where nothing speaks for a change; found on a grid of sizes but for one direction, which has a
        closed form.

    References
    ----------
    S. G. Self, K.-Y. Liang, J. American Statistical Association 82, 1987, 605-610.
    """
    if len(squares) == 1:  # closed: s l = z^2 - 1
        return float(squares[0] - 1.0 - np.log(squares[0])) if squares[0] > 1.0 else 0.0
    return max(float(_ratios(squares, information).max()), 0.0)


def _ratios(squares: FloatArray, information: FloatArray) -> FloatArray:
    """Return twice the log likelihood ratio at each size of the grid."""
    wound = _SIZES[:, None] * information / information.max()
    each = squares * wound / (1.0 + wound) - np.log1p(wound)
    return np.asarray(each.sum(axis=1))
