"""Distance accuracy AD and distance repeatability RD, ISO 9283:1998, 7.3: between the poses P2 and P4.

With D_j the distance between the two attained positions of cycle j, and D_c that between the commanded ones:

    AD = mean(D) - D_c        RD = +-3 S_D        and the same of |x_2 - x_4|, |y_2 - y_4|, |z_2 - z_4|
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.sentences import Sentence, said
from truepose.judgement.iso9283.characteristics import Characteristic, Component, Performance, Withheld
from truepose.judgement.iso9283.moments import common, of_mean, three_scatters
from truepose.judgement.iso9283.pose import CYCLES
from truepose.judgement.iso9283.visits import CommandedPose, Visits, too_few

ENDS: Final = (2, 4)
_PARTS: Final[tuple[Component, ...]] = ("p", "x", "y", "z")


def distance_performance(
    commanded: Sequence[CommandedPose], visits: Visits, ends: tuple[int, int] = ENDS
) -> Performance:
    """Return AD and RD between two poses.

    Parameters
    ----------
    commanded : sequence of CommandedPose
        The two among them.
    visits : Visits
    ends : tuple of int
        Numbers of the two poses.

    Returns
    -------
    Performance
        Withheld where fewer than 30 cycles hold both ends. The instrument's stated uncertainty counts once
        for each end in AD; it does not touch RD. First order fails for a part that is commanded to be 0,
        whose size cannot fall: what is stated there is too large.

    Raises
    ------
    ConfigurationError
        One of the two poses is not commanded.
    """
    places = {pose.number: np.array(pose.position_mm) for pose in commanded}
    for number in ends:
        if number not in places:
            raise ConfigurationError(
                f"P{number} is not among the commanded poses: the distance has no end there."
            )
    subject = f"P{ends[0]}-P{ends[1]}"
    one, other = _of_both(visits, ends)
    if len(one) < CYCLES:
        reason = _reason(visits, ends, len(one))
        return Performance((), (Withheld("AD", subject, reason), Withheld("RD", subject, reason)))
    asked = places[ends[0]] - places[ends[1]]
    return Performance(tuple(_figures(one, other, asked, subject)), ())


def _of_both(visits: Visits, ends: tuple[int, int]) -> tuple[Visits, Visits]:
    """Return the visits of both ends, of the cycles that hold both."""
    one, other = (visits.of_pose(number) for number in ends)
    _, first, second = np.intersect1d(one.cycle, other.cycle, return_indices=True)
    return one.taken(first), other.taken(second)


def _reason(visits: Visits, ends: tuple[int, int], both: int) -> Sentence:
    reasons = [why for number in ends if (why := too_few(visits, number, CYCLES)) is not None]
    return reasons[0] if reasons else said("poses.both_ends", both=both, least=CYCLES)


def _figures(one: Visits, other: Visits, asked: FloatArray, subject: str) -> Iterator[Characteristic]:
    n, apart = len(one), one.position_mm - other.position_mm
    ends = float(np.hypot(common(one.standard_uncertainty_mm), common(other.standard_uncertainty_mm)))
    lengths = (np.linalg.norm(apart, axis=1), *np.abs(apart).T)
    wanted = (float(np.linalg.norm(asked)), *np.abs(asked))
    for name, length, whole in zip(_PARTS, lengths, wanted, strict=True):
        u = float(np.hypot(of_mean(length), ends))
        yield Characteristic("AD", name, subject, float((length - whole).mean()), u, "mm", n)
        yield Characteristic("RD", name, subject, *three_scatters(length), "mm", n, 3.0 * ends)
