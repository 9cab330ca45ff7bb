"""A corrected file: how many targets, how well, which not, and which file came of which."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.correction import CorrectedTargets, CorrectionTotals, FileCorrection, UncorrectedTarget
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message
from truepose.reports.cover_page import Front, OneFigure, graded
from truepose.reports.report import Description, Report
from truepose.reports.rounding import MISSING, format_fixed, millimetres, uncertainty_mm

_MOST_ROWS: Final = 500  # of targets on paper; the corrected file has all
_MOST_SAID: Final = 10
_WHY: Final = {
    "joint_limit": "corrections.not.joint_limit",
    "out_of_reach": "corrections.not.out_of_reach",
    "singular": "corrections.not.singular",
}


def correction_sentences(totals: CorrectionTotals) -> Iterator[Message]:
    """Yield how many targets were corrected, how well, and which were not."""
    yield message("corrections.done", solved=totals.solved, targets=totals.targets)
    if totals.solved:
        yield _how_well(totals)
    unknown = totals.statuses.get("limits_unknown", 0)
    if unknown:
        yield message("corrections.limits_unknown", count=unknown)
    if totals.far_moved:
        largest = math.degrees(totals.largest_move_rad)
        yield message("corrections.far_moved", count=totals.far_moved, largest_deg=largest)
    yield from _outside_limits(totals)
    for name, status in totals.failed[:_MOST_SAID]:
        yield message(_WHY[status], target=name)
    left = totals.targets - totals.solved - _MOST_SAID
    if left > 0:
        yield message("corrections.more", left=left)


def left_alone_sentences(left_alone: Sequence[UncorrectedTarget]) -> Iterator[Message]:
    """Yield what of a program was left alone, and why."""
    for one in left_alone:
        yield message("corrections.left_alone", place=one.place, what=one.what, reason=one.reason)


def _how_well(totals: CorrectionTotals) -> Message:
    mean, largest = totals.mean_uncertainty_mm, totals.largest_uncertainty_mm
    if math.isnan(mean):
        return message("corrections.uncertainty_unknown")
    return message("corrections.how_well", mean_mm=mean, largest_mm=largest)


def _outside_limits(totals: CorrectionTotals) -> Iterator[Message]:
    if not totals.zone_known:
        yield message("corrections.zone_unknown")
    elif totals.outside:
        yield message(
            "corrections.outside",
            outside=totals.outside,
            # Both: where only joints are outside the zone the sentence would say by up to 0 mm (commit
            # c1062c34).
            farthest_deg=math.degrees(totals.farthest_outside_rad),
            farthest_mm=totals.farthest_outside_mm,
        )


_HEADS: Final = (
    "corrected.head.line",
    "corrected.head.target",
    "corrected.head.status",
    "corrected.head.shift",
    "corrected.head.uncertainty",
    "corrected.head.outside",
    "corrected.head.moved",
)
_STATUSES: Final = {
    "ok": "corrected.status.ok",
    "limits_unknown": "corrected.status.limits_unknown",
    "joint_limit": "corrected.status.joint_limit",
    "out_of_reach": "corrected.status.out_of_reach",
    "singular": "corrected.status.singular",
}


@dataclass(frozen=True, slots=True)
class CorrectionReport(Report):
    """A file before and after its correction, and some of its targets."""

    name: str  # of the file
    robot: str
    correction: FileCorrection
    targets: CorrectedTargets
    hashes: tuple[str, str]  # SHA-256 of the file before and after
    first: int = 0  # of the targets that are listed, 0-based
    most: int = _MOST_ROWS

    def described(self, words: Catalogue) -> Description:
        """Return what was done and what was not, the shifts, the targets, and both files."""
        from truepose.reports.figures.error_maps import shift_map  # the drawing library is slow to import

        sentence, *others = map(words.spoken, correction_sentences(self.correction.totals))
        shown = {
            "report": self,
            "sentences": others,
            "cautions": [*map(words.spoken, self.correction.cautions)],
            "drawn": shift_map(self.targets, words),
            "heads": [*map(words.say, _HEADS)],
            "rows": tuple(target_rows(self.targets, words, self.first, self.most)),
            "following": self.following,
            "total": len(self.targets.names),
        }
        front = _front(self, sentence, words)
        return Description(front.title, self.robot, "correction.html", shown, front)

    @property
    def following(self) -> int | None:
        """Behind how many targets the next ones stand; None: all others are listed."""
        last = self.first + self.most
        return last if last < len(self.targets.names) else None


def _front(report: CorrectionReport, sentence: str, words: Catalogue) -> Front:
    totals = report.correction.totals
    whole = totals.solved == totals.targets > 0 and not report.correction.left_alone
    figure = None
    if totals.solved:
        largest = words.units.quantity(uncertainty_mm(totals.largest_uncertainty_mm), "mm")
        figure = OneFigure(
            words.say("front.correction.uncertainty"), largest, words.say("front.correction.u")
        )
    return Front(
        title=words.say("correct.of", name=report.name),
        look=graded(True) if whole else "partly_explained" if totals.solved else graded(False),
        word=words.say("front.correction.whole" if whole else "front.correction.part"),
        outcome=words.say("outcome.unproved"),
        sentence=sentence,
        robot=report.robot,
        figure=figure,
        rule=words.say("front.correction.prove"),
    )


def target_rows(
    targets: CorrectedTargets, words: Catalogue, first: int, count: int
) -> Iterator[tuple[str, ...]]:
    """Yield the cells of some targets, of those from `first` (0-based) on."""
    shift = np.linalg.norm(targets.shift_mm, axis=1)
    for row in range(first, min(first + count, len(targets.names))):
        yield (
            str(targets.lines[row]),
            targets.names[row],
            words.say(_STATUSES[targets.statuses[row]]),
            millimetres(float(shift[row])),
            uncertainty_mm(float(targets.uncertainty_mm[row])),
            _outside_text(float(targets.outside_mm[row]), words),
            format_fixed(math.degrees(float(targets.moved_rad[row])), 3, "deg"),
        )


def _outside_text(value_mm: float, words: Catalogue) -> str:
    if not math.isfinite(value_mm):
        return MISSING
    return millimetres(value_mm) if value_mm > 0.0 else words.say("corrected.within")
