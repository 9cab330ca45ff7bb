"""Drifts: rigid motions that go on, evenly or settling.

A parameter `<prefix>_<shape>_<component>` is a rate [mm/h, rad/h]; after t hours

    linear      rate t
    exp<tau>    rate tau (1 - exp(-t / tau))        tau in seconds in the name

the rate is that at the origin of times, and a motion that settles dies out.

A made model knows an even drift as far as readings followed it, and holds it where they began and ended; one
that settles is known to its end.
"""

from collections.abc import Callable

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene
from truepose.effects.motions import (
    SECONDS_PER_HOUR,
    Widths,
    duration_s,
    fitted_motion,
    hours_followed,
    hours_since,
    motion_specs,
    split_motion,
    spoken,
    without_times,
)
from truepose.effects.ports import Need, ParameterSpec, Port, Rows, Setting, Term
from truepose.messages.message import Message, Text, message

LINEAR = "linear"
_WIDTH_MM_PER_H = 0.3  # five times a drift that a calibration engineer would call serious
_WIDTH_RAD_PER_H = 3e-4
_SHORTEST_S = 600.0  # of the grid of time constants, which doubles from one to the next
# Within a sixteenth of the measurements it is over before it is seen; beyond all of them it is even.
_FASTEST, _SLOWEST = 1.0 / 16.0, 1.0


class RigidDrift:
    """What drifts of base and instrument have in common: six rates, even or settling."""

    name: str
    place: str  # what moves: the subject of its candidates
    prefix: str  # of its parameters' names
    needs: frozenset[Need] = frozenset({"time"})

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return the rates of an even drift."""
        return drift_specs(self.prefix, LINEAR)

    def goes_on(self, names: tuple[str, ...]) -> bool:
        """Return whether one of the shapes has no end of its own: an even drift, which a made model holds."""
        return any(_shape_of(split_motion(name)[0]) == LINEAR for name in names)

    def unseen(self, scene: Scene) -> Text | None:
        """Need times."""
        return without_times(scene)

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose an even drift and settling ones."""
        return () if self.unseen(scene) else drift_candidates(self.name, self.place, self.prefix, scene)


def drift_specs(prefix: str, shape: str) -> tuple[ParameterSpec, ...]:
    """Return the six rates of one shape.

    A motion that dies out early has a way of its own to go: its rates may be larger in proportion.

    Parameters
    ----------
    prefix : str
    shape : str
        `linear`, or `exp<tau>` with tau in seconds.
    """
    tau_s = _time_constant_s(shape)
    # The way of a motion that settles is rate times tau at most: an hour's worth of way takes so much more
    # rate.
    wider = 1.0 if tau_s is None else max(1.0, SECONDS_PER_HOUR / tau_s)
    widths = Widths(_WIDTH_MM_PER_H * wider, _WIDTH_RAD_PER_H * wider, "mm/h", "rad/h")
    return motion_specs(f"{prefix}_{shape}", widths)


def drift_terms(names: tuple[str, ...], rows: Rows, port: Callable[[int], Port]) -> list[Term]:
    """Move ports by their rates times the way of their shape [h], not at all where no time is.

    Parameters
    ----------
    names : tuple of str
        `<prefix>_<shape>_<component>`.
    rows : Rows
    port : callable
        Component to port.
    """
    split = [split_motion(name) for name in names]
    # Once for each shape: its six components share one way.
    ways = {prefix: np.nan_to_num(_come_h(_shape_of(prefix), rows)) for prefix, _ in split}
    return [Term(k, port(component), ways[prefix]) for k, (prefix, component) in enumerate(split)]


def drift_candidates(effect: str, subject: str, prefix: str, scene: Scene) -> tuple[Candidate, ...]:
    """Propose an even drift, and settling ones with time constants that these measurements can tell.

    Parameters
    ----------
    effect, subject : str
        Of the candidates.
    prefix : str
        Of the parameters' names.
    scene : Scene
    """
    # An even drift is searched over nothing and has no variant; each time constant is one, and pays for the
    # search.
    proposed = [Candidate(effect, subject, drift_specs(prefix, LINEAR))]
    proposed += [
        Candidate(effect, subject, drift_specs(prefix, f"exp{tau_s:g}"), tau_s)
        for tau_s in _time_constants_s(duration_s(scene))
    ]
    return tuple(candidate for candidate in proposed if candidate.names[0] not in scene.present)


def describe_drift(subject: str, fitted: FittedCause, scene: Scene, who: Message) -> Description:
    """Say how fast `who` moves, on average over the measurements; several shapes are added up.

    Parameters
    ----------
    subject : str
    fitted : FittedCause
        Rates [mm/h, rad/h] of one or more shapes.
    scene : Scene
    who : Message

    Returns
    -------
    Description
        Amplitude: length of the mean rate of the shift [mm/h].
    """
    # A second at least: a rate per hour of readings at one time would be a division by zero.
    hours = max(duration_s(scene), 1.0) / SECONDS_PER_HOUR
    motion = fitted_motion(fitted, lambda prefix: _mean_rate(_shape_of(prefix), hours))
    rate, uncertainty = motion.shift
    constants = _constants_s(fitted)
    sentence = message(
        "causes.drift",
        who=who,
        rate_mm_per_h=rate,
        turn_deg_per_h=motion.turn_deg[0],
        settling=tuple(message("causes.drift.settling", constant=spoken(tau_s)) for tau_s in constants),
        way_mm=rate * hours,
        span=spoken(SECONDS_PER_HOUR * hours),
    )
    details = (*motion.details("/h"), *_constant_details(constants))
    return Description(subject, rate, "mm/h", uncertainty, sentence, details)


def _constant_details(constants_s: list[float]) -> list[Detail]:
    """Time constants are searched on a grid of factor two: known to its step, evenly spread."""
    return [Detail("time_constant", tau_s, "s", tau_s / float(np.sqrt(12.0))) for tau_s in constants_s]


def _constants_s(fitted: FittedCause) -> list[float]:
    shapes = {_shape_of(split_motion(name)[0]) for name in fitted.names}
    return sorted(tau_s for tau_s in map(_time_constant_s, shapes) if tau_s is not None)


def _shape_of(prefix: str) -> str:
    return prefix.rsplit("_", 1)[1]


def _time_constant_s(shape: str) -> float | None:
    return None if shape == LINEAR else float(shape.removeprefix("exp"))


def _come_h(shape: str, rows: Rows) -> FloatArray:
    """Way per rate [h] that each row has come, NaN where no time is, shape (n,)."""
    return _way_h(shape, hours_followed(rows) if shape == LINEAR else hours_since(rows, rows.origin_s))


def _way_h(shape: str, hours: FloatArray) -> FloatArray:
    """Way per rate [h]; a motion that settles begins with the measurements."""
    tau_s = _time_constant_s(shape)
    if tau_s is None:
        return hours
    tau_h = tau_s / SECONDS_PER_HOUR
    # expm1 keeps the digits while t is short against tau; before the origin the exponential would grow beyond
    # bound, so that such rows count as at the origin.
    return np.asarray(-tau_h * np.expm1(-np.maximum(hours, 0.0) / tau_h))


def _mean_rate(shape: str, hours: float) -> float:
    """Return the way over the measurements per rate and hour [1]: 1 of an even drift, else less."""
    return float(_way_h(shape, np.array([hours]))[0] / hours)


def _time_constants_s(duration_s: float) -> list[float]:
    """Return the time constants that are tried [s]: 600 s times powers of 2, within 1/16 to all of it."""
    if duration_s <= 0.0:
        return []
    lowest = int(np.ceil(np.log2(_FASTEST * duration_s / _SHORTEST_S)))
    highest = int(np.floor(np.log2(_SLOWEST * duration_s / _SHORTEST_S)))
    return [_SHORTEST_S * 2.0**power for power in range(lowest, highest + 1)]
