"""Whether a reading goes with the pair of cup and nest that was asked for.

Bayes' rule over everything that a person may have connected, and the costs of both errors: with the odds o_a
of each account a (slips, `misconnections`) and its likelihood L_a, a person is asked where

    sum of o_a L_a over the accounts of one other pair  >  (cost of asking / cost of a wrong length)
                                                            * sum of o_a L_a over those of the asked pair.

A question costs ten seconds, a pose that is measured again a minute. A wrong length that stays costs at least
that minute, and where nothing shows it later it bends the identification of a whole hour: 1,000 s in the mean
is a guess on the safe side. So a reading is suspected where one other pair has more than a hundredth of the
probability of what was asked, a whole pose where one other account of it has more than six hundredths. One
other, not all together: where the forecast is vague, many accounts are a little likely, and a question would
lead nowhere.
"""

from collections.abc import Mapping

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import Leg, PoseForecast, Suspicion
from truepose.domain.errors import ConfigurationError
from truepose.validation.misconnections import (
    LengthForecast,
    foreseen_by,
    likeliest,
    log_likelihood,
    nothing_foreseen,
    slip_kind,
    slips,
    total,
)

_WRONG_S = 1000.0  # cost of a wrong length that stays
_ASK = float(np.log(10.0 / _WRONG_S))  # log of the odds of wrong against right above which a person is asked
_REPEAT = float(np.log(60.0 / _WRONG_S))  # ... above which a pose is measured again


def judge_leg(
    asked: Leg,
    length_mm: float,
    earlier: Mapping[Leg, float],
    forecast: PoseForecast | None,
    *,
    reading_u_mm: float,
    zero_u_mm: float,
    nominal_mm: float,
    range_mm: float,
) -> Suspicion | None:
    """Judge one reading by what is foreseen and by what was read before at the same stop.

    Parameters
    ----------
    asked : (cup, nest)
    length_mm : float
    earlier : mapping of leg to length [mm]
        Kept readings of the stop. One of the asked leg itself is superseded and not looked at.
    forecast : PoseForecast, optional
        Of every pair. Without it only a pair that is read twice can be seen.
    reading_u_mm, zero_u_mm : float
        Standard uncertainties of a reading, and of the zero from one connection to the next.
    nominal_mm, range_mm : float
        Where the ballbar can read at all.

    Returns
    -------
    Suspicion or None
        None: the reading goes with what was asked, as far as anybody can tell.

    Raises
    ------
    ConfigurationError
        A length, an uncertainty or the range is no number, or the forecast does not know a leg.
    """
    # The asked leg comes last: it is the reading that is judged, and an earlier one of it is replaced.
    readings = {leg: length for leg, length in earlier.items() if leg != asked} | {asked: length_mm}
    noise, spread = _checked_noise(readings, reading_u_mm, zero_u_mm), _checked_spread(range_mm)
    if forecast is None:
        foreseen = nothing_foreseen(tuple(readings), nominal_mm, noise, spread)
    else:
        foreseen = foreseen_by(forecast, noise, spread)
    assignments, odds = _judged(foreseen, readings, questioned=False)
    own = foreseen.index(asked)
    right = assignments[:, -1] == own
    best, best_odds = likeliest(assignments[~right], odds[~right])
    if best is None or best_odds < _ASK + total(odds[right]):
        return None
    expected = None if forecast is None else float(foreseen.length_mm[own])
    return _suspicion(best, len(readings) - 1, foreseen, readings, expected)


def judge_pose(
    lengths: Mapping[Leg, float],
    forecast: PoseForecast,
    *,
    reading_u_mm: float,
    zero_u_mm: float,
    range_mm: float,
) -> tuple[Suspicion, ...]:
    """Judge all readings of one stop together: legs that changed places, and what was missed one by one.

    Parameters
    ----------
    lengths : mapping of leg to length [mm]
    forecast : PoseForecast
        Of every pair; it may be made after the pose was measured.
    reading_u_mm, zero_u_mm, range_mm : float
        As for `judge_leg`.

    Returns
    -------
    tuple of Suspicion
        One for each reading that is wrong in the likeliest account of them all; empty where they go with what
        was asked.

    Raises
    ------
    ConfigurationError
        As for `judge_leg`.
    """
    if not lengths:
        return ()
    noise, spread = _checked_noise(lengths, reading_u_mm, zero_u_mm), _checked_spread(range_mm)
    foreseen = foreseen_by(forecast, noise, spread)
    assignments, odds = _judged(foreseen, lengths, questioned=True)
    row = 1 + int(np.argmax(odds[1:]))
    if odds[row] < _REPEAT + odds[0]:
        return ()
    best = assignments[row]
    own = assignments[0]
    return tuple(
        _suspicion(best, reading, foreseen, lengths, float(foreseen.length_mm[own[reading]]))
        for reading in np.flatnonzero(best != own).tolist()
    )


def _checked_noise(readings: Mapping[Leg, float], reading_u_mm: float, zero_u_mm: float) -> float:
    """Return the variance of one reading."""
    for (cup, nest), length in readings.items():
        if not np.isfinite(length):
            raise ConfigurationError(f"The ballbar length B{cup} T{nest} is not a number. Read it again.")
    noise = reading_u_mm**2 + zero_u_mm**2
    if not (np.isfinite(noise) and noise > 0.0):
        raise ConfigurationError("The uncertainty of a reading must be greater than 0 mm.")
    return noise


def _checked_spread(range_mm: float) -> float:
    """Return the variance of a length that may be anywhere within the range."""
    if not 0.0 < range_mm < np.inf:
        raise ConfigurationError(f"The ballbar range must be greater than 0 mm (got {range_mm:g} mm).")
    # An even distribution over -range to +range has the variance range^2 / 3.
    return range_mm**2 / 3.0


def _judged(
    foreseen: LengthForecast, readings: Mapping[Leg, float], *, questioned: bool
) -> tuple[IntArray, FloatArray]:
    """Return what the readings may be of (m, k), first what was asked, and the log of its odds (m,).

    Prior odds of the slip plus log likelihood of the readings, not normalised.
    """
    asked = [foreseen.index(leg) for leg in readings]
    assignments, before = slips(asked, len(foreseen.pairs), questioned=questioned)
    return assignments, before + log_likelihood(foreseen, tuple(readings), readings, assignments)


def _suspicion(
    account: IntArray,
    reading: int,
    foreseen: LengthForecast,
    readings: Mapping[Leg, float],
    expected_mm: float | None,
) -> Suspicion:
    """Return the suspicion that an account raises about one reading."""
    legs, pairs = tuple(readings), foreseen.pairs
    instead = int(account[reading])
    suspected = pairs[instead] if instead < len(pairs) else None
    kind = slip_kind(account, np.array([foreseen.index(leg) for leg in legs]), instead, len(pairs))
    return Suspicion(kind, legs[reading], suspected, float(readings[legs[reading]]), expected_mm)
