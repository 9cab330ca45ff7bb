"""What a table of corrected targets came to, in sentences."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from truepose.correction import Summary
from truepose.domain.sentences import Sentence, said
from truepose.exchange.programs.program import LeftAlone

_MOST_SAID: Final = 10
_WHY: Final = {
    "joint_limit": "corrections.not.joint_limit",
    "out_of_reach": "corrections.not.out_of_reach",
    "singular": "corrections.not.singular",
}


def correction_sentences(summary: Summary) -> Iterator[Sentence]:
    """Yield how many targets were corrected, how well, and which were not."""
    yield said("corrections.done", solved=summary.solved, targets=summary.targets)
    if summary.solved:
        mean, largest = summary.mean_uncertainty_mm, summary.largest_uncertainty_mm
        yield said("corrections.how_well", mean_mm=mean, largest_mm=largest)
    if summary.far_moved:
        largest = math.degrees(summary.largest_move_rad)
        yield said("corrections.far_moved", count=summary.far_moved, largest_deg=largest)
    yield from _outside(summary)
    for name, status in summary.failed[:_MOST_SAID]:
        yield said(_WHY[status], target=name)
    left = summary.targets - summary.solved - _MOST_SAID
    if left > 0:
        yield said("corrections.more", left=left)


def left_alone_sentences(left_alone: Sequence[LeftAlone]) -> Iterator[Sentence]:
    """Yield what of a program was left alone, and why."""
    for one in left_alone:
        yield said("corrections.left_alone", place=one.place, what=one.what, reason=one.reason)


def _outside(summary: Summary) -> Iterator[Sentence]:
    if not summary.zone_known:
        yield said("corrections.zone_unknown")
    elif summary.outside:
        farthest = summary.farthest_outside_mm
        yield said("corrections.outside", outside=summary.outside, farthest_mm=farthest)
