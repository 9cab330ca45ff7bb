"""What a table of corrected targets came to, in sentences."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from truepose.domain.results.corrections import CorrectionTotals, LeftAlone
from truepose.domain.sentences import Sentence, said

_MOST_SAID: Final = 10
_WHY: Final = {
    "joint_limit": "corrections.not.joint_limit",
    "out_of_reach": "corrections.not.out_of_reach",
    "singular": "corrections.not.singular",
}


def correction_sentences(totals: CorrectionTotals) -> Iterator[Sentence]:
    """Yield how many targets were corrected, how well, and which were not."""
    yield said("corrections.done", solved=totals.solved, targets=totals.targets)
    if totals.solved:
        mean, largest = totals.mean_uncertainty_mm, totals.largest_uncertainty_mm
        yield said("corrections.how_well", mean_mm=mean, largest_mm=largest)
    unknown = totals.statuses.get("limits_unknown", 0)
    if unknown:
        yield said("corrections.limits_unknown", count=unknown)
    if totals.far_moved:
        largest = math.degrees(totals.largest_move_rad)
        yield said("corrections.far_moved", count=totals.far_moved, largest_deg=largest)
    yield from _outside(totals)
    for name, status in totals.failed[:_MOST_SAID]:
        yield said(_WHY[status], target=name)
    left = totals.targets - totals.solved - _MOST_SAID
    if left > 0:
        yield said("corrections.more", left=left)


def left_alone_sentences(left_alone: Sequence[LeftAlone]) -> Iterator[Sentence]:
    """Yield what of a program was left alone, and why."""
    for one in left_alone:
        yield said("corrections.left_alone", place=one.place, what=one.what, reason=one.reason)


def _outside(totals: CorrectionTotals) -> Iterator[Sentence]:
    if not totals.zone_known:
        yield said("corrections.zone_unknown")
    elif totals.outside:
        yield said(
            "corrections.outside",
            outside=totals.outside,
            farthest_deg=math.degrees(totals.farthest_outside_rad),
            farthest_mm=totals.farthest_outside_mm,
        )
