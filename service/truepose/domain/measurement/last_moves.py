"""Last moves: how far each joint came to a stop, from the stop before it in time.

An arm that approaches its stops by moves of its own comes from elsewhere: it gives itself away where a joint
came against its way from the stop before.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.measurement.campaign import Campaign, ContactReadings, LegReadings, PointReadings, Stops

_Readings = TypeVar("_Readings", PointReadings, LegReadings, ContactReadings)
_AGAINST = 0.02  # share of moves that may go against the stated direction before none is believed


def with_last_moves(campaign: Campaign) -> Campaign:
    """Return a campaign whose stops say how far each joint came, before any of its rows are left out."""
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
    return None if readings is None else replace(readings, stops=told_moves(readings.stops))


def told_moves(stops: Stops) -> Stops:
    """Return stops that say how far each joint came, as far as their times tell it."""
    if stops.move_rad is not None or stops.time_s is None or not _ordered(stops.time_s, stops.config):
        return stops
    move = _from_the_stop_before(stops, np.argsort(stops.time_s, kind="stable"))
    against = _against(stops, move)
    moved = np.isfinite(move)
    if against.sum() > _AGAINST * moved.sum():
        return stops
    return replace(stops, move_rad=np.where(against, np.nan, move))


def _ordered(time_s: FloatArray, config: IntArray) -> bool:
    """Whether every row has a time, and no two configurations share one."""
    if not len(config) or not np.isfinite(time_s).all():
        return False
    timed = np.unique(np.stack([time_s, config], axis=1), axis=0)
    return bool((np.diff(timed[:, 0]) > 0.0).all())


def _from_the_stop_before(stops: Stops, order: IntArray) -> FloatArray:
    """Return the moves between configurations in the order of time, shape (n, J) [rad]; NaN at the first."""
    config, joints = stops.config[order], stops.joints_rad[order]
    arrived = np.flatnonzero(np.diff(config) != 0) + 1  # in the order of time
    steps = np.full_like(joints, np.nan)
    steps[arrived] = joints[arrived] - joints[arrived - 1]
    latest = np.zeros(len(config), dtype=int)
    latest[arrived] = arrived
    move = np.empty_like(joints)
    move[order] = steps[np.maximum.accumulate(latest)]
    return move


def _against(stops: Stops, move: FloatArray) -> BoolArray:
    """Return which joints came against the way from the stop before, shape (n, J)."""
    if stops.direction is None:
        return np.zeros(move.shape, dtype=bool)
    return np.asarray(np.nan_to_num(move) * stops.direction < 0.0)
