r"""The smallest change of each cause that the campaigns of a fleet would have shown.

A change that comes to v along directions E, evenly from the first campaign to the last (at once at the last
where there are two), gives its score (`fleet.trials`) the noncentrality

    lambda = v' F v        F = E' I E / excess

so that what it is judged by is noncentral chi-square. Let lambda_q be that with which it is beyond the level
of one try with 95 %. What it moves the tool by, s^2 = v' S v with S = E' motion E, is then shown in every
direction from

    s^2 = lambda_q / smallest eigenvalue of S^-1/2 F S^-1/2

on. An instrument's line is judged by the squared ratio of Student's t, which is noncentral F, with
lambda = v^2 / (variance of the slope) at the variance of its days.

That is what one try shows: a change that another try shows as well, as a step for instance, is shown from
less on.

References
----------
P. B. Patnaik, Biometrika 36, 1949, 202-232 (power by the noncentral chi-square and F).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.special import chdtri, chndtrinc, fdtri, ncfdtrinc

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.fleet.campaigns import Fleet
from truepose.fleet.causes import AgeingCause, instrument_cause
from truepose.fleet.changes import Account
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.trials import Score, shapes

SHOWN: Final = 0.95
_UNSEEN: Final = 1e-9  # of the largest eigenvalue


@dataclass(frozen=True, slots=True)
class DetectableChange:
    """From which size on a cause would have been shown in each of some robots, or instruments.

    Attributes
    ----------
    cause : AgeingCause
    of : tuple of str
        Of which it is not named already.
    size_mm : ndarray, shape (len(of),)
        As changes are measured; inf: of no size.
    days : ndarray, shape (len(of),)
        From the first campaign to the last, over which it grows.
    """

    cause: AgeingCause
    of: tuple[str, ...]
    size_mm: FloatArray
    days: FloatArray


def least_of_robots(account: Account) -> tuple[DetectableChange, ...]:
    """Return one for each cause that was tried, of the robots that were measured on two days at least.

    Parameters
    ----------
    account : Account

    Returns
    -------
    tuple of DetectableChange
        In the order of the causes.
    """
    fleet, posterior = account.fleet, account.estimated.posterior
    own = {name: fleet.robot == number for number, name in enumerate(fleet.robots)}
    ways = {name: _growing(fleet.day, among) for name, among in own.items()}
    scores = {name: Score(posterior, shape) for name, shape in ways.items() if shape is not None}
    days = {name: float(np.ptp(fleet.day[own[name]])) for name in scores}
    chance = account.tries.chance("robot")

    def of(cause: AgeingCause, excess: float) -> DetectableChange:
        # What is named has been shown, whatever its size.
        names = tuple(name for name in scores if not _is_named(account, name, cause))
        sizes = [_least_mm(fleet, cause, scores[name], excess, chance) for name in names]
        return DetectableChange(cause, names, np.array(sizes), np.array([days[name] for name in names]))

    return tuple(map(of, account.tries.causes, account.tries.excess))


def least_of_instruments(account: Account) -> DetectableChange:
    """Return that of the instruments' lengths.

    Parameters
    ----------
    account : Account

    Returns
    -------
    DetectableChange
        inf of an instrument whose scale was told on too few days.
    """
    fleet, cause = account.fleet, instrument_cause(account.fleet)
    instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))
    scales, chance = InstrumentDays(account.estimated.posterior), account.tries.chance("instrument")
    unit_mm = float(np.sqrt(fleet.motion_mm2[-1, -1]))
    own = {
        name: instrument == number
        for number, name in enumerate(fleet.instruments)
        if not _is_named(account, name, cause) and number in instrument  # not all of it is left out
    }
    least = [_least_scale(scales, _line(day, among), chance) for among in own.values()]
    sizes = [unit_mm * one if np.isfinite(one) else np.inf for one in least]
    days = [float(np.ptp(day[among])) for among in own.values()]
    return DetectableChange(cause, tuple(own), np.array(sizes), np.array(days))


def _is_named(account: Account, of: str, cause: AgeingCause) -> bool:
    return any(one.change.is_of(of, cause) for one in account.named)


def _growing(day: FloatArray, among: BoolArray) -> FloatArray | None:
    """Return the line over some campaigns, of two days their step; None: they are of one day."""
    return next((shape for *_, shape in shapes(day, among)), None)


def _line(day: FloatArray, among: BoolArray) -> FloatArray | None:
    return next((shape for kind, _, shape in shapes(day, among) if kind == "linear"), None)


def _least_scale(scales: InstrumentDays, line: FloatArray | None, chance: float) -> float:
    """Return the least drift in stated widths, u sqrt(lambda); inf: it was there on too few days.

    lambda is the noncentrality with which F of 1 and the days' degrees exceeds its limit with 95 %.
    """
    # Two days give no line beside the level and the scatter of days.
    u, degrees = (np.inf, 0) if line is None else scales.judging(line)
    if degrees < 1:
        return np.inf
    limit = float(fdtri(1.0, degrees, 1.0 - chance))
    return float(u * np.sqrt(ncfdtrinc(1.0, degrees, 1.0 - SHOWN, limit)))


def _least_mm(fleet: Fleet, cause: AgeingCause, score: Score, excess: float, chance: float) -> float:
    """Return the least size that is shown in every direction of a cause [mm]; inf: in some it is not seen.

    In units of 1 mm, U = V diag(m)^-1/2 of E' M E = V diag(m) V': sqrt(lambda / smallest eigenvalue of U' F
    U).
    """
    seen = cause.directions.T @ score.information @ cause.directions / excess
    moved = cause.directions.T @ fleet.motion_mm2 @ cause.directions
    values, turns = np.linalg.eigh(moved)
    # Directions that move nothing have no size that could be shown.
    moving = values > _UNSEEN * max(float(values[-1]), 1e-300)
    unit = turns[:, moving] / np.sqrt(values[moving])  # 1 mm along each
    least = np.linalg.eigvalsh(unit.T @ seen @ unit)
    # A cause is shown only if it is in every direction: a wave may come in the phase that no campaign
    # sees.
    if not len(least) or least[0] <= _UNSEEN * least[-1]:
        return np.inf
    return float(np.sqrt(noncentrality(chance, len(least)) / least[0]))


def noncentrality(chance: float, degrees: int) -> float:
    """Return the noncentrality with which a chi-square is beyond what chance gives with 95 %.

    Parameters
    ----------
    chance : float
        Up to which a chi-square counts as beyond.
    degrees : int
        Of freedom.

    Returns
    -------
    float
        lambda.

    References
    ----------
    P. B. Patnaik, Biometrika 36, 1949, 202-232.
    """
    return float(chndtrinc(chdtri(degrees, chance), degrees, 1.0 - SHOWN))
