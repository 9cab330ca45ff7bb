"""Where a function of one variable is zero, without its derivatives.

References
----------
T. R. Chandrupatla, A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function
without using derivatives, Adv. Eng. Software 28, 1997.
"""

from collections.abc import Callable
from typing import NamedTuple

_TOLERANCE = 1e-6  # of the crossing
_SMALLEST = 1e-12  # and, for one near zero, absolutely


class _At(NamedTuple):
    x: float
    value: float


def crossing(function: Callable[[float], float], low: float, high: float) -> float:
    """Return where `function` is zero, by Chandrupatla's method.

    Parameters
    ----------
    function : callable
        Continuous; of different signs at the two ends.
    low, high : float
        The two ends, in the unit of the argument.

    Returns
    -------
    float
        Within a millionth of itself, or within 1e-12 where it is near zero.
    """
    new, other = (_At(x, function(x)) for x in (high, low))
    before = other
    share = 0.5
    while True:
        x = new.x + share * (other.x - new.x)
        latest = _At(x, function(x))
        if (latest.value > 0.0) == (new.value > 0.0):
            before = new
        else:
            before, other = other, new
        new = latest
        nearest = min(new, other, key=lambda at: abs(at.value))
        smallest = (_TOLERANCE * abs(nearest.x) + _SMALLEST) / abs(other.x - new.x)
        if nearest.value == 0.0 or smallest > 0.5:
            return nearest.x
        share = min(max(_next_share(new, other, before), smallest), 1.0 - smallest)


def _next_share(new: _At, other: _At, before: _At) -> float:
    """Return where to look next, from `new` (0) to `other` (1): on a parabola, or in the middle."""
    xi = (new.x - other.x) / (before.x - other.x)
    phi = (new.value - other.value) / (before.value - other.value)
    if phi**2 >= xi or (1.0 - phi) ** 2 >= 1.0 - xi:
        return 0.5
    chord = new.value / (other.value - new.value) * before.value / (other.value - before.value)
    bend = (before.x - new.x) / (other.x - new.x)
    return chord + bend * new.value / (before.value - new.value) * other.value / (before.value - other.value)
