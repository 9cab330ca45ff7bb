"""Sudden motions: something stood still, jumped once, and stood still again.

A parameter `<prefix>_<time>_<component>` acts from that time [s] on. Every gap between two stops may hold the
jump; a jump within a gap cannot be placed any better than the gap.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.measurement.campaign import Stops
from truepose.effects.causes import Scene
from truepose.effects.ports import Port, Rows, Term
from truepose.effects.shapes.rigid_motion import split_motion
from truepose.effects.shapes.times import moments_s

_LEAST_POSITIONS = 4  # on either side: six parameters need more than two
_LEAST_LENGTHS = 12
_MOST = 120  # gaps that are tried; of more, every second or third


class Gap(NamedTuple):
    """A time between two stops."""

    middle_s: float
    width_s: float

    @property
    def label(self) -> str:
        """The time as names carry it: with as many decimals as keep it within the gap."""
        decimals = max(0, int(np.ceil(-np.log10(self.width_s / 4.0))))
        return f"{self.middle_s:.{decimals}f}"


def gaps_of_all(scene: Scene) -> tuple[Gap, ...]:
    """Return the gaps with enough of all readings on either side for a rigid motion."""
    least = _LEAST_LENGTHS if scene.legs else _LEAST_POSITIONS
    return gaps(scene.stops, np.ones(len(scene.stops), dtype=bool), least)


def gaps(stops: Stops, rows: BoolArray, least_readings: int) -> tuple[Gap, ...]:
    """Return the gaps between stops that have enough readings on either side, in the order of time.

    Parameters
    ----------
    stops : Stops
    rows : ndarray, shape (n,)
        Readings that count.
    least_readings : int
        On either side.
    """
    if stops.time_s is None:
        return ()
    chosen = np.flatnonzero(rows & np.isfinite(stops.time_s))
    order = chosen[np.argsort(stops.time_s[chosen], kind="stable")]
    time_s, config = stops.time_s[order], stops.config[order]
    ends = np.arange(1, len(order))
    apart = (config[1:] != config[:-1]) & (np.diff(time_s) > 0.0)
    enough = (ends >= least_readings) & (len(order) - ends >= least_readings)
    return tuple(
        Gap(float(time_s[k - 1] + time_s[k]) / 2.0, float(time_s[k] - time_s[k - 1]))
        for k in ends[apart & enough].tolist()
    )


def tried(
    found: tuple[Gap, ...], between_s: tuple[float, float] | None, most: int = _MOST
) -> tuple[Gap, ...]:
    """Return the gaps at which a jump is tried: all between two moments, else at most so many, evenly."""
    if between_s is None:
        return found[:: max(1, -(-len(found) // most))]
    return tuple(gap for gap in found if between_s[0] < gap.middle_s < between_s[1])


def around(found: tuple[Gap, ...], time_s: float) -> Gap:
    """Return the gap that holds a time, the nearest where none does."""
    return min(found, key=lambda gap: abs(gap.middle_s - time_s))


def jump_terms(names: tuple[str, ...], rows: Rows, port: Callable[[str, int], Port]) -> list[Term]:
    """Move `port` of each prefix and component from the prefix's time on."""
    split = [split_motion(name) for name in names]
    later = {prefix: since(rows, jump_time_s(prefix)) for prefix, _ in split}
    return [Term(k, port(prefix, component), later[prefix]) for k, (prefix, component) in enumerate(split)]


def jump_time_s(prefix: str) -> float:
    """Return the time of e.g. `jump_1234.5`."""
    return float(prefix.rsplit("_", 1)[1])


def since(rows: Rows, time_s: float) -> FloatArray:
    """Return 1 from a moment [s] on, 0 before it and where a time is missing to make a model, shape (n,)."""
    return np.asarray(moments_s(rows) >= time_s, dtype=float)
