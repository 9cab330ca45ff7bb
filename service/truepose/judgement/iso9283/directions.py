"""Multi-directional pose accuracy variation vAP, ISO 9283:1998, 7.2.3.

The same pose is visited from three directions, parallel to the axes of the base; vAP is the largest distance
between the barycentres that these give, and the largest difference of their mean angles.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.sentences import said
from truepose.judgement.iso9283.characteristics import Characteristic, Component, Performance, Withheld
from truepose.judgement.iso9283.moments import barycentre, barycentre_covariance, norm_uncertainty, of_mean
from truepose.judgement.iso9283.pose import CYCLES
from truepose.judgement.iso9283.visits import Visits, too_few

DIRECTIONS: Final = 3
POSES: Final = (1, 2, 4)  # those that the test visits
_TURNS: Final[tuple[Component, ...]] = ("a", "b", "c")


def direction_performance(approaches: Sequence[Visits], poses: Sequence[int] = POSES) -> Performance:
    """Return vAP of each pose.

    Parameters
    ----------
    approaches : sequence of Visits
        Three, one per direction.
    poses : sequence of int
        Numbers of the poses that were visited.

    Returns
    -------
    Performance
        A pose that one of the directions visited in fewer than 30 cycles is withheld. A constant error
        of the instrument cancels and is not in the uncertainty.

    Raises
    ------
    ConfigurationError
        There are not three directions.
    """
    if len(approaches) != DIRECTIONS:
        raise ConfigurationError(f"vAP needs visits from three directions, and there are {len(approaches)}.")
    found = Performance((), ())
    for number in poses:
        found = found.joined(_one_pose(approaches, number))
    return found


def _one_pose(approaches: Sequence[Visits], number: int) -> Performance:
    for place, visits in enumerate(approaches, start=1):
        reason = too_few(visits, number, CYCLES)
        if reason is not None:
            why = said("poses.from_direction", direction=place, reason=reason)
            return Performance((), (Withheld("vAP", f"P{number}", why),))
    seen = [visits.of_pose(number) for visits in approaches]
    return Performance((_of_position(seen, number), *_of_angles(seen, number)), ())


def _of_position(seen: Sequence[Visits], number: int) -> Characteristic:
    one, other = max(combinations(seen, 2), key=lambda pair: float(np.linalg.norm(_shift_mm(*pair))))
    shift = _shift_mm(one, other)
    covariance = barycentre_covariance(one.position_mm) + barycentre_covariance(other.position_mm)
    u = norm_uncertainty(shift, covariance)
    value = float(np.linalg.norm(shift))
    return Characteristic("vAP", "p", f"P{number}", value, u, "mm", sum(map(len, seen)))


def _shift_mm(one: Visits, other: Visits) -> FloatArray:
    return barycentre(one.position_mm) - barycentre(other.position_mm)


def _of_angles(seen: Sequence[Visits], number: int) -> Iterator[Characteristic]:
    turns = [visits.turn_rad for visits in seen if visits.turn_rad is not None]
    if len(turns) != len(seen):
        return
    for axis, name in enumerate(_TURNS):
        means = [float(turn[:, axis].mean()) for turn in turns]
        low, high = int(np.argmin(means)), int(np.argmax(means))
        u = float(np.hypot(of_mean(turns[low][:, axis]), of_mean(turns[high][:, axis])))
        value = means[high] - means[low]
        yield Characteristic("vAP", name, f"P{number}", value, u, "rad", sum(map(len, seen)))
