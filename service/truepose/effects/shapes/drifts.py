"""Slow motions in time, even or settling: what drifts of base and instrument have in common.

A parameter `<prefix>_<shape>_<component>` is a rate [mm/h, rad/h]. Of the shape `linear` the way after t
hours is rate * t, of `exp<tau>` it is rate * tau * (1 - exp(-t / tau)), tau in seconds in the name: the rate
is that at the origin of times, and the motion dies out.

A made model knows an even drift as far as readings followed it, and holds it where they began and ended; one
that settles is known to its end.
"""

from collections.abc import Callable

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.causes import Detail
from truepose.domain.sentences import Sentence, said
from truepose.effects.causes import Candidate, Fitted, Scene, Shown
from truepose.effects.ports import ParameterSpec, Port, Rows, Term
from truepose.effects.shapes.rigid_motion import Widths, fitted_motion, motion_specs, split_motion
from truepose.effects.shapes.times import SECONDS_PER_HOUR, duration_s, hours_followed, hours_since, spoken

LINEAR = "linear"
_WIDTH_MM_PER_H = 0.3  # five times a drift that a calibration engineer would call serious
_WIDTH_RAD_PER_H = 3e-4
_SHORTEST_S = 600.0  # of the grid of time constants, which doubles from one to the next
# Within a sixteenth of the measurements it is over before it is seen; beyond all of them it is even.
_FASTEST, _SLOWEST = 1.0 / 16.0, 1.0


def drift_specs(prefix: str, shape: str) -> tuple[ParameterSpec, ...]:
    """Return the six rates of one shape.

    A motion that dies out early has a way of its own to go: its rates may be larger in proportion.
    """
    tau_s = _time_constant_s(shape)
    wider = 1.0 if tau_s is None else max(1.0, SECONDS_PER_HOUR / tau_s)
    widths = Widths(_WIDTH_MM_PER_H * wider, _WIDTH_RAD_PER_H * wider, "mm/h", "rad/h")
    return motion_specs(f"{prefix}_{shape}", widths)


def drift_terms(names: tuple[str, ...], rows: Rows, port: Callable[[int], Port]) -> list[Term]:
    """Move `port` of each component by its rate times the way of its shape, not at all where no time is."""
    split = [split_motion(name) for name in names]
    ways = {prefix: np.nan_to_num(_come_h(_shape_of(prefix), rows)) for prefix, _ in split}
    return [Term(k, port(component), ways[prefix]) for k, (prefix, component) in enumerate(split)]


def goes_on(names: tuple[str, ...]) -> bool:
    """Return whether one of the shapes has no end of its own."""
    return any(_shape_of(split_motion(name)[0]) == LINEAR for name in names)


def drift_candidates(effect: str, subject: str, prefix: str, scene: Scene) -> tuple[Candidate, ...]:
    """Propose an even drift, and settling ones with time constants that these measurements can tell."""
    proposed = [Candidate(effect, subject, drift_specs(prefix, LINEAR))]
    proposed += [
        Candidate(effect, subject, drift_specs(prefix, f"exp{tau_s:g}"), tau_s)
        for tau_s in _time_constants_s(duration_s(scene))
    ]
    return tuple(candidate for candidate in proposed if candidate.names[0] not in scene.present)


def shown_drift(subject: str, fitted: Fitted, scene: Scene, who: Sentence) -> Shown:
    """Say how fast `who` moves, on average over the measurements; several shapes are added up."""
    hours = max(duration_s(scene), 1.0) / SECONDS_PER_HOUR
    motion = fitted_motion(fitted, lambda prefix: _mean_rate(_shape_of(prefix), hours))
    rate, uncertainty = motion.shift
    constants = _constants_s(fitted)
    sentence = said(
        "causes.drift",
        who=who,
        rate_mm_per_h=rate,
        turn_deg_per_h=motion.turn_deg[0],
        settling=tuple(said("causes.drift.settling", constant=spoken(tau_s)) for tau_s in constants),
        way_mm=rate * hours,
        span=spoken(SECONDS_PER_HOUR * hours),
    )
    details = (*motion.details("/h"), *_constant_details(constants))
    return Shown(subject, rate, "mm/h", uncertainty, sentence, details)


def _constant_details(constants_s: list[float]) -> list[Detail]:
    """Time constants are searched on a grid of factor two: known to its step, evenly spread."""
    return [Detail("time_constant", tau_s, "s", tau_s / float(np.sqrt(12.0))) for tau_s in constants_s]


def _constants_s(fitted: Fitted) -> list[float]:
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
    return np.asarray(-tau_h * np.expm1(-np.maximum(hours, 0.0) / tau_h))


def _mean_rate(shape: str, hours: float) -> float:
    return float(_way_h(shape, np.array([hours]))[0] / hours)


def _time_constants_s(duration_s: float) -> list[float]:
    if duration_s <= 0.0:
        return []
    lowest = int(np.ceil(np.log2(_FASTEST * duration_s / _SHORTEST_S)))
    highest = int(np.floor(np.log2(_SLOWEST * duration_s / _SHORTEST_S)))
    return [_SHORTEST_S * 2.0**power for power in range(lowest, highest + 1)]
