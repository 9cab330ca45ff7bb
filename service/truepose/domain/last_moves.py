"""Last moves: how far each joint came to a stop, from the stop before it in time.

An arm that approaches its stops by moves of its own comes from elsewhere: it gives itself away where a joint
came against its way from the stop before.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Campaign, ContactReadings, LegReadings, PointReadings, Stops

_Readings = TypeVar("_Readings", PointReadings, LegReadings, ContactReadings)
_AGAINST = 0.02  # share of moves that may go against the stated direction before none is believed


def with_last_moves(campaign: Campaign) -> Campaign:
    """Return a campaign whose stops say how far each joint came, before any of its rows are left out.

    Parameters
    ----------
    campaign : Campaign
        Of all its readings: a stop that was left out before would be missing in front of the next one.
    """
    return replace(
        campaign,
        calibration=_told(campaign.calibration),
        validation=_told(campaign.validation),
        legs=_told(campaign.legs),
        validation_legs=_told(campaign.validation_legs),
        contacts=_told(campaign.contacts),
        validation_contacts=_told(campaign.validation_contacts),
    )


def _told(readings: _Readings | None) -> _Readings | None:
    return None if readings is None else replace(readings, stops=with_moves(readings.stops))


def with_moves(stops: Stops) -> Stops:
    """Return stops that say how far each joint came, as far as their times tell it.

    Parameters
    ----------
    stops : Stops
        n rows.

    Returns
    -------
    Stops
        With `move_rad` (n, J), NaN where a joint came against its way; as they were where times are missing
        or shared, or where more than 2 % of the moves go against the stated directions.
    """
    if stops.move_rad is not None or stops.time_s is None or not _ordered(stops.time_s, stops.config):
        return stops
    move = _from_the_stop_before(stops, np.argsort(stops.time_s, kind="stable"))
    against = _against(stops, move)
    moved = np.isfinite(move)
    # Where many joints come against their way, the arm approached its stops from elsewhere, and those that
    # happen to agree tell nothing either.
    if against.sum() > _AGAINST * moved.sum():
        return stops
    return replace(stops, move_rad=np.where(against, np.nan, move))


def _ordered(time_s: FloatArray, config: IntArray) -> bool:
    """Whether every row has a time, and no two configurations share one."""
    if not len(config) or not np.isfinite(time_s).all():
        return False
    timed = np.unique(np.stack([time_s, config], axis=1), axis=0)
    # Several readings of one stop may share a time; two configurations at one time have no order.
    return bool((np.diff(timed[:, 0]) > 0.0).all())


def _from_the_stop_before(stops: Stops, order: IntArray) -> FloatArray:
    """Return the moves between configurations in the order of time.

    Parameters
    ----------
    stops : Stops
        n rows.
    order : ndarray of int, shape (n,)
        Rows in the order of time.

    Returns
    -------
    ndarray, shape (n, J)
        [rad]; NaN at the first configuration.
    """
    config, joints = stops.config[order], stops.joints_rad[order]
    arrived = np.flatnonzero(np.diff(config) != 0) + 1  # in the order of time
    steps = np.full_like(joints, np.nan)
    steps[arrived] = joints[arrived] - joints[arrived - 1]
    latest = np.zeros(len(config), dtype=int)
    latest[arrived] = arrived
    move = np.empty_like(joints)
    # Every reading of a stop has the move by which the arm came there, also the second and the third.
    move[order] = steps[np.maximum.accumulate(latest)]
    return move


def _against(stops: Stops, move: FloatArray) -> BoolArray:
    """Return which joints came against the way from the stop before, (n, J); none without directions."""
    if stops.direction is None:
        return np.zeros(move.shape, dtype=bool)
    return np.asarray(np.nan_to_num(move) * stops.direction < 0.0)
