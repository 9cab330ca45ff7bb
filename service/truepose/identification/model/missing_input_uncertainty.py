"""Rows that do not tell what an effect depends on: it is left out there, and the uncertainty says so.

What the effect would have done is unknown, but not how much it usually does: the prediction p is made again
with each of m things that the row might have said (temperatures within the campaign's range, every direction
of approach, moves of the usual size either way, every mounting that the model knows), and

    u^2 = sum over the m of |p_i - p|^2 / (3 m)        per axis

is added to the variance of its positions. A row without a time is later than all readings: `validity` tells
how much less is known there.

A usual move is that between two configurations drawn evenly from a range of width w: root mean square
w / sqrt(6).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.robot import Robot
from truepose.effects.motions import SECONDS_PER_HOUR
from truepose.effects.ports import Need, Trait
from truepose.effects.registry import effects_with, needs_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.structure import Structure
from truepose.identification.model.validity import hours_beyond
from truepose.messages.message import Message, message

_LACKED: dict[Need, str] = {
    "time": "cautions.time",
    "temperature": "cautions.temperature",
    "direction": "cautions.direction",
    "move": "cautions.move",
    "attachment": "cautions.attachment",
    "initialisation": "cautions.initialisation",
}
_ANY_RANGE_RAD = np.pi  # of joints whose ranges are not stated
_ROUNDING_H = 1e-3 / SECONDS_PER_HOUR  # of stored times
_STEPS = 8  # temperatures that stand for the whole of their range


@dataclass(frozen=True, slots=True)
class Span:
    """What the readings covered that made a model and judged it.

    Attributes
    ----------
    duration_s : float
        From the origin of times to the last reading; an hour's campaign where the model does not say.
    lowest_c, highest_c : float
        Temperatures; those of a workshop's year where the model does not say.
    """

    duration_s: float = SECONDS_PER_HOUR
    lowest_c: float = 15.0
    highest_c: float = 30.0


def span_of(identified_from: dict[str, str | int | float]) -> Span:
    """Return what a model says about the readings that it was made from.

    Parameters
    ----------
    identified_from : dict
        With `duration_s`, `lowest_temperature_c`, `highest_temperature_c` as far as they were known.
    """
    known = {
        key: float(value)
        for key, name in (
            ("duration_s", "duration_s"),
            ("lowest_c", "lowest_temperature_c"),
            ("highest_c", "highest_temperature_c"),
        )
        if isinstance(value := identified_from.get(name), int | float)
    }
    return Span(**known)


def span_of_readings(read: Sequence[Stops], origin_s: float) -> dict[str, float]:
    """Return what a model is to say about its readings, those that judge it too, as far as it is known.

    Parameters
    ----------
    read : sequence of Stops
    origin_s : float
        Time from which drifts and warm-ups count.

    Returns
    -------
    dict
        `duration_s`, `lowest_temperature_c`, `highest_temperature_c`; without what no row tells.
    """
    found = {}
    # Readings that judge a model belong to its campaign, as they were taken in one go with the others.
    times, temperatures = (
        np.concatenate([_known(column) for column in columns])
        for columns in ([stops.time_s for stops in read], [stops.temperature_c for stops in read])
    )
    if times.size:
        found["duration_s"] = float(times.max()) - origin_s
    if temperatures.size:
        found["lowest_temperature_c"] = float(temperatures.min())
        found["highest_temperature_c"] = float(temperatures.max())
    return found


def _known(column: FloatArray | None) -> FloatArray:
    return np.zeros(0) if column is None else column[np.isfinite(column)]


def missing_input_sentences(structure: Structure, targets: Targets) -> tuple[Message, ...]:
    """Return one sentence for every effect that some of the targets do not tell enough about.

    Parameters
    ----------
    structure : Structure
        Of a made model.
    targets : Targets
        Whose rows are counted in the sentences.
    """
    sentences = []
    for effect, need in _asked(structure, targets):
        rows = int(_lacking(structure, effect, need, targets).sum())
        if rows:
            sentences.append(message(_LACKED[need], effect=effect, rows=rows, targets=len(targets)))
    return tuple(sentences)


def missing_input_variance(
    structure: Structure, values: FloatArray, targets: Targets, position_mm: FloatArray, span: Span
) -> FloatArray:
    """Return the variance per axis that what is left out adds to each position.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (P,)
        Internal units.
    targets : Targets
        n of them.
    position_mm : ndarray, shape (n, 3)
        As predicted with what the targets tell.
    span : Span
        Of the readings that the model was made from.

    Returns
    -------
    ndarray, shape (n,)
        [mm2], mean of the three axes.
    """
    variance = np.zeros(len(targets))
    asked = _asked(structure, targets)
    for need in sorted({need for _, need in asked}):
        # Effects that need the same are left out together: one temperature would move all of them.
        effects = [effect for effect, own in asked if own == need]
        masks = [_lacking(structure, effect, need, targets) for effect in effects]
        rows = np.flatnonzero(np.any(masks, axis=0))
        if rows.size == 0:
            continue
        # Only the rows that lack something are predicted anew.
        some = targets.taken(rows)
        changes = [
            evaluate(structure, values, replace(some, stops=stops)).position_mm - position_mm[rows]
            for stops in _imagined(structure, effects, need, some.stops, span)
        ]
        if changes:
            variance[rows] += np.mean([(change**2).sum(axis=1) / 3.0 for change in changes], axis=0)
    return variance


def _asked(structure: Structure, targets: Targets) -> list[tuple[str, Need]]:
    """Effects of the model with what each needs; joint torques are asked for before any prediction."""
    # What a ballbar reads too much moves no position.
    idle = effects_with(Trait.OF_LENGTHS) if targets.length_mm is None else ()
    return [
        (effect, need)
        for effect in structure.effects
        if effect in structure.owners and effect not in idle
        for need in sorted(needs_of(effect, structure.names_of(effect)))
        if need in _LACKED
    ]


def _lacking(structure: Structure, effect: str, need: Need, targets: Targets) -> BoolArray:
    """Return which rows do not tell what an effect needs, shape (n,)."""
    stops, names = targets.stops, structure.names_of(effect)
    joints = _joints(names, structure.robot.n_joints)
    match need:
        # Only the joints of the effect's parameters: others may come from anywhere.
        case "direction" if stops.direction is not None:
            return np.asarray((stops.direction[:, joints] == 0).any(axis=1))
        case "move" if stops.move_rad is not None:
            return np.asarray(~np.isfinite(stops.move_rad[:, joints]).all(axis=1))
        case "time" if stops.time_s is not None:
            return np.asarray(~np.isfinite(stops.time_s))
        case "temperature" if stops.temperature_c is not None:
            return np.asarray(~np.isfinite(stops.temperature_c))
        case "attachment" if stops.attachment is not None:
            return _unknown(stops.attachment, names)
        case "initialisation" if targets.initialisation is not None:
            # Numbers begin at 1 in each session: beyond the readings they are those of another one.
            another = hours_beyond(structure, stops) > _ROUNDING_H
            return _unknown(targets.initialisation, names) | another
    # The whole column is missing.
    return np.ones(len(targets), dtype=bool)


def _unknown(column: IntArray, names: tuple[str, ...]) -> BoolArray:
    """Return the rows of mountings or initialisations that the parameters do not know."""
    # A parameter a mounting: one that was not there when the model was made has none.
    numbers = _numbers(names)
    return np.asarray(~np.isin(column, numbers) if numbers else column < 0)


def _numbers(names: tuple[str, ...]) -> list[int]:
    """Return the mountings or initialisations that parameters are of, e.g. 2 of `seat_2_rx`."""
    second = (name.split("_")[1:2] for name in names)
    return sorted({int(part) for parts in second for part in parts if part.isdecimal()})


def _joints(names: tuple[str, ...], n_joints: int) -> list[int]:
    """Return the 0-based joints that parameters are of, e.g. 1 of `gap_2`; all where a name tells none."""
    last = [name.rsplit("_", 1)[-1] for name in names]
    if not all(part.isdecimal() and 1 <= int(part) <= n_joints for part in last):
        return list(range(n_joints))
    return sorted({int(part) - 1 for part in last})


def _imagined(
    structure: Structure, effects: list[str], need: Need, stops: Stops, span: Span
) -> Iterator[Stops]:
    """Yield the stops with everything that they might have said."""
    # In the middle of equal parts: their mean square is that of an even spread over the whole range.
    middles = (np.arange(_STEPS) + 0.5) / _STEPS
    match need:
        case "temperature":
            for celsius in span.lowest_c + (span.highest_c - span.lowest_c) * middles:
                yield replace(stops, temperature_c=np.full(len(stops), celsius))
        case "direction":
            for signs in _signs(structure.robot.n_joints):
                yield replace(stops, direction=np.tile(signs, (len(stops), 1)))
        case "move":
            for signs in _signs(structure.robot.n_joints):
                yield replace(
                    stops, move_rad=np.tile(_usual_move_rad(structure.robot) * signs, (len(stops), 1))
                )
        case "attachment":
            for number in sorted({n for effect in effects for n in _numbers(structure.names_of(effect))}):
                yield replace(stops, attachment=np.full(len(stops), number))


def _usual_move_rad(robot: Robot) -> FloatArray:
    """Return the root mean square of moves between configurations drawn from the ranges, shape (J,)."""
    # The difference of two draws from an even spread of width w has the variance w^2 / 6.
    width = [limit.upper_rad - limit.lower_rad for limit in robot.calibration_ranges or ()]
    usual: FloatArray = np.array(width or [_ANY_RANGE_RAD] * robot.n_joints) / np.sqrt(6.0)
    return usual


def _signs(joints: int) -> IntArray:
    """Directions of approach in which every two joints agree as often as not, shape (m, J)."""
    # All 2^J combinations are not needed: the mean square of a sum is that of its parts where every two
    # signs agree as often as not. The first column, which never changes, is left out.
    signs = np.ones((1, 1), dtype=np.int64)
    while len(signs) <= joints:  # Sylvester's construction of Hadamard matrices
        signs = np.block([[signs, signs], [signs, -signs]])
    return signs[:, 1 : joints + 1]
