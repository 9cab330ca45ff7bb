"""Readings that a person sets aside: which of a campaign they are, and the campaign without them."""

from dataclasses import replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray
from truepose.domain.campaign import (
    Campaign,
    ContactReadings,
    LegReadings,
    ReadingName,
    Readings,
    ReadingsSetAside,
)
from truepose.domain.errors import ConfigurationError
from truepose.domain.last_moves import with_last_moves
from truepose.messages.message import Message, Text, message

# Of the readings that identify. Beyond it single readings are no accidents: it is the campaign that is wrong.
MOST_SET_ASIDE: Final = 0.2


def found_in(campaign: Campaign, wanted: ReadingsSetAside) -> ReadingsSetAside:
    """Return readings to set aside with their rows.

    Parameters
    ----------
    campaign : Campaign
    wanted : ReadingsSetAside
        Its rows do not count.

    Returns
    -------
    ReadingsSetAside
        Each reading once.

    Raises
    ------
    ConfigurationError
        The campaign has no such reading, or it judges the model; or they are more than a fifth.
    """
    readings = campaign.readings
    size = 0 if readings is None else len(readings)
    chosen = np.zeros(size, dtype=bool)
    names = tuple(dict.fromkeys(wanted.readings))
    for name in names:
        rows = _rows_of(readings, name)
        if not rows.any():
            raise ConfigurationError(_refusal(campaign, name))
        chosen |= rows
    if chosen.sum() > MOST_SET_ASIDE * size:
        raise ConfigurationError(
            message("refused.set_aside_many", n=int(chosen.sum()), total=size, most=MOST_SET_ASIDE)
        )
    return replace(wanted, readings=names, rows=tuple(np.flatnonzero(chosen).tolist()))


def _rows_of(readings: Readings | None, name: ReadingName) -> BoolArray:
    if readings is None:
        return np.zeros(0, dtype=bool)
    rows: BoolArray = (readings.stops.config == name.config) & (readings.nest == name.nest)
    if name.base_point is not None:
        rows &= isinstance(readings, LegReadings) and readings.base_point == name.base_point
    if name.target is not None:
        rows &= isinstance(readings, ContactReadings) and readings.target == name.target
    return rows


def _refusal(campaign: Campaign, name: ReadingName) -> Message:
    """Say why a reading cannot be set aside that does not identify."""
    judging = (campaign.validation, campaign.validation_legs, campaign.validation_contacts)
    # Without a reading that judges it, a result would look better and be no better.
    judges = any(_rows_of(readings, name).any() for readings in judging)
    key = "refused.set_aside_judging" if judges else "refused.set_aside_unknown"
    return message(key, reading=named(name))


def named(reading: ReadingName) -> Message:
    """Return a reading as people name it."""
    if reading.base_point is not None:
        return message(
            "set_aside.leg", config=reading.config, base_point=reading.base_point, nest=reading.nest
        )
    if reading.target is not None:
        return message("set_aside.contact", config=reading.config, target=reading.target, nest=reading.nest)
    return message("set_aside.point", config=reading.config, nest=reading.nest)


def listed(aside: ReadingsSetAside | None) -> Text:
    """Return each of the readings set aside; empty where none were."""
    return "" if aside is None else message("set_aside.listed", readings=tuple(map(named, aside.readings)))


def without_readings(campaign: Campaign, aside: ReadingsSetAside) -> Campaign:
    """Return a campaign without the readings that were found in it, which says so.

    Parameters
    ----------
    campaign : Campaign
        Of all its readings.
    aside : ReadingsSetAside
        With their rows.
    """
    readings = campaign.readings
    if readings is None:
        return campaign
    left = np.setdiff1d(np.arange(len(readings)), np.array(aside.rows, dtype=np.int64))
    # Before: the arm was there, and came from there to its next stop.
    return replace(with_last_moves(campaign).of_rows(left), set_aside=aside)
