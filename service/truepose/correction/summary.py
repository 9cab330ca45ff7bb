"""What a whole table of targets came to, added up part by part."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.correction.corrections import Corrections

MOST_NAMED: Final = 100
FAR_RAD: Final = float(
    np.deg2rad(5.0)
)  # corrections turn joints by tenths of a degree, except near a singularity


class Summary:
    """Counts and extremes of corrected targets; holds no rows but the names of the first that failed."""

    def __init__(self) -> None:
        self.statuses: Counter[str] = Counter()
        self.failed: list[tuple[str, str]] = []  # name and status, at most MOST_NAMED
        self.largest_error_mm = self.largest_uncertainty_mm = self.farthest_outside_mm = 0.0
        self.far_moved = 0  # solved targets at which a joint turns far from the controller's own answer
        self.largest_move_rad = 0.0
        self.outside = 0  # solved targets outside the measured zone
        self.zone_known = True
        self._uncertainty_mm = 0.0

    def add(self, names: Sequence[str], found: Corrections) -> None:
        """Count some rows."""
        self.statuses.update(found.status.tolist())
        failed = np.flatnonzero(~found.solved).tolist()
        self.failed += [
            (names[row], str(found.status[row])) for row in failed[: MOST_NAMED - len(self.failed)]
        ]
        solved = found.taken(np.flatnonzero(found.solved))
        self.largest_error_mm = max(self.largest_error_mm, float(solved.error_mm.max(initial=0.0)))
        largest = float(solved.uncertainty_mm.max(initial=0.0))
        self.largest_uncertainty_mm = max(self.largest_uncertainty_mm, largest)
        self._uncertainty_mm += float(solved.uncertainty_mm.sum())
        moved = np.nan_to_num(solved.moved_rad)
        self.far_moved += int((moved > FAR_RAD).sum())
        self.largest_move_rad = max(self.largest_move_rad, float(moved.max(initial=0.0)))
        self.zone_known = self.zone_known and not np.isnan(solved.outside_mm).any()
        beyond = (solved.outside_mm > 0.0) | (solved.outside_rad > 0.0).any(axis=1)
        self.outside += int(beyond.sum())
        farthest = float(np.nan_to_num(solved.outside_mm).max(initial=0.0))
        self.farthest_outside_mm = max(self.farthest_outside_mm, farthest)

    @property
    def targets(self) -> int:
        """How many targets there were."""
        return self.statuses.total()

    @property
    def solved(self) -> int:
        """How many were corrected."""
        return self.statuses["ok"]

    @property
    def mean_uncertainty_mm(self) -> float:
        """Mean standard uncertainty per axis of those that were corrected; 0 where none was."""
        return self._uncertainty_mm / max(self.solved, 1)
