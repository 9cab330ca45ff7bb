"""What is left of a way of straight joint motions for an arm that was halted on it."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from truepose.sequencing.engine.motion.segments import Joints


def rest_of_way(way: Sequence[Joints], here: Joints, allowed_rad: float) -> tuple[Joints, ...]:
    """Return what is left of a way for an arm that stands somewhere on it, the end in any case.

    Halted between two of its points, on the straight line of the joints, the arm goes on to the later one.
    From a place beside the way, and before its first point, it is the whole way.
    """
    passed = [n for n, joints in enumerate(way) if _apart(here, joints) <= allowed_rad]
    between = [n for n, (a, b) in enumerate(pairwise(way)) if _off_line(here, a, b) <= allowed_rad]
    last = max(passed or between, default=None)
    return tuple(way if last is None else way[min(last + 1, len(way) - 1) :])


def _apart(here: Joints, there: Joints) -> float:
    """Return the largest difference of a joint [rad]; of arms that are not alike, infinity."""
    return float(np.max(np.abs(np.subtract(here, there)))) if len(here) == len(there) else math.inf


def _off_line(here: Joints, start: Joints, end: Joints) -> float:
    """Return how far the joints are off the straight motion between two others [rad]."""
    way = np.subtract(end, start)
    if len(here) != len(way) or not np.any(way):
        return math.inf
    share = float(np.clip(np.dot(np.subtract(here, start), way) / np.dot(way, way), 0.0, 1.0))
    return float(np.max(np.abs(np.subtract(here, np.add(start, share * way)))))
