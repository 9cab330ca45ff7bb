"""Readings that a person sets aside: which of a campaign they are, and the campaign without them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeAlias

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
_MOST_LISTED: Final = 6  # readings of one configuration, in a refusal
# Configuration, what it was read against (base point or target, where there is one) and tool nest; or the
# configuration alone.
ReadingNumbers: TypeAlias = tuple[int, ...]


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
    # Of a reading named twice the first reason, as of one named once.
    why = dict(reversed([*zip(wanted.readings, wanted.reason_of_each, strict=True)]))
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
    return replace(
        wanted,
        readings=names,
        rows=tuple(np.flatnonzero(chosen).tolist()),
        reasons=tuple(why[name] for name in names),
    )


def named_by_numbers(
    campaign: Campaign, wanted: Sequence[tuple[ReadingNumbers, str]], person: str
) -> ReadingsSetAside:
    """Return the readings that somebody names by their numbers, each with its own reason.

    Parameters
    ----------
    campaign : Campaign
    wanted : sequence of (tuple of int, str)
        Numbers of a reading, and why it is set aside; at least one.
    person : str

    Returns
    -------
    ReadingsSetAside
        Still without rows.

    Raises
    ------
    ConfigurationError
        Some numbers are those of no reading that identifies, or of several; or two are those of the same.
    """
    names = tuple(_named_by(campaign, numbers) for numbers, _ in wanted)
    twice = next((name for name, count in Counter(names).items() if count > 1), None)
    if twice is not None:
        raise ConfigurationError(message("refused.set_aside_twice", reading=named(twice)))
    reasons = tuple(reason for _, reason in wanted)
    different = dict.fromkeys(reasons)
    joined = "; ".join(reason.rstrip(".") for reason in different) if len(different) > 1 else reasons[0]
    return ReadingsSetAside(names, joined, person, reasons=reasons)


def _named_by(campaign: Campaign, numbers: ReadingNumbers) -> ReadingName:
    fitting = [name for name in _names(campaign.readings) if numbers in {numbers_of(name), (name.config,)}]
    if len(fitting) == 1:
        return fitting[0]
    if fitting:
        raise ConfigurationError(_ambiguous(fitting))
    for judging in _judging(campaign):
        for name in _names(judging):
            if numbers in {numbers_of(name), (name.config,)}:
                return name  # and is refused with the reason for that
    raise ConfigurationError(_unknown(campaign, numbers, _as_typed(numbers)))


def _ambiguous(fitting: Sequence[ReadingName]) -> Message:
    labels = [label(name) for name in fitting]
    listed_labels = labels if len(labels) <= _MOST_LISTED else [*labels[:_MOST_LISTED], "..."]
    config, n = fitting[0].config, len(fitting)
    return message("refused.set_aside_ambiguous", config=config, readings=n, labels=tuple(listed_labels))


def _as_typed(numbers: ReadingNumbers) -> Text:
    if len(numbers) == 1:
        return message("set_aside.config", config=numbers[0])
    return "/".join(map(str, numbers))


def _names(readings: Readings | None) -> list[ReadingName]:
    """Return the name of each reading once, in the order of their table."""
    if readings is None:
        return []
    config, nest = readings.stops.config.tolist(), readings.nest.tolist()
    base_point = target = [None] * len(readings)
    if isinstance(readings, LegReadings):
        base_point = readings.base_point.tolist()
    if isinstance(readings, ContactReadings):
        target = readings.target.tolist()
    # Of a sensor all axes are one reading.
    return list(dict.fromkeys(map(ReadingName, config, nest, base_point, target)))


def numbers_of(name: ReadingName) -> ReadingNumbers:
    """Return the numbers that tell a reading, in the order in which `named` says them."""
    read_against = name.target if name.base_point is None else name.base_point
    return (name.config, name.nest) if read_against is None else (name.config, read_against, name.nest)


def label(name: ReadingName) -> str:
    """Return the numbers of a reading as they are typed, such as 17/2."""
    return "/".join(map(str, numbers_of(name)))


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
    # Without a reading that judges it, a result would look better and be no better.
    if any(_rows_of(readings, name).any() for readings in _judging(campaign)):
        return message("refused.set_aside_judging", reading=named(name))
    return _unknown(campaign, numbers_of(name), named(name))


def _judging(campaign: Campaign) -> tuple[Readings | None, ...]:
    return campaign.validation, campaign.validation_legs, campaign.validation_contacts


def _unknown(campaign: Campaign, numbers: ReadingNumbers, reading: Text) -> Message:
    known = _names(campaign.readings)
    if not known:
        return message("refused.set_aside_none", reading=reading)
    nearest = min(known, key=lambda name: _away(numbers, numbers_of(name)))
    return message("refused.set_aside_unknown", reading=reading, nearest=named(nearest), label=label(nearest))


def _away(numbers: ReadingNumbers, others: ReadingNumbers) -> tuple[int, ...]:
    """Return how far numbers are from those of a reading: by configuration, then nest, then the rest."""
    first, *rest = numbers
    by_nest = [abs(a - b) for a, b in zip(reversed(rest), reversed(others[1:]), strict=False)]
    return (abs(first - others[0]), *by_nest)


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
    """Return each of the readings set aside, with its reason where they differ; empty where none were."""
    if aside is None:
        return ""
    readings = tuple(map(named, aside.readings))
    if len(set(aside.reasons)) > 1:
        each = zip(readings, aside.reasons, strict=True)
        readings = tuple(message("set_aside.why", reading=reading, reason=reason) for reading, reason in each)
    return message("set_aside.listed", readings=readings)


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
