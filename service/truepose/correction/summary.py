"""What a whole table of targets came to, added up part by part."""

from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.correction.corrections import Corrections
from truepose.correction.limits import FAR_RAD
from truepose.domain.arrays import FloatArray
from truepose.domain.results.corrections import CORRECTED, CorrectionTotals

MOST_NAMED: Final = 100


class Summary:
    """Counts and extremes of corrected targets; holds no rows but the names of the first that failed."""

    def __init__(self) -> None:
        self._statuses: Counter[str] = Counter()
        self._failed: list[tuple[str, str]] = []  # name and status, at most MOST_NAMED
        self._largest_error_mm = self._largest_uncertainty_mm = 0.0
        self._far_moved = 0  # solved targets at which a joint turns far from the controller's own answer
        self._largest_move_rad = 0.0
        self._outside = 0  # solved targets outside the measured zone
        self._farthest_outside_mm = self._farthest_outside_rad = 0.0
        self._zone_known = True
        self._uncertainty_mm = 0.0

    def add(self, names: Sequence[str], found: Corrections) -> None:
        """Count some rows."""
        self._statuses.update(found.status.tolist())
        failed = np.flatnonzero(~found.solved).tolist()
        self._failed += [
            (names[row], str(found.status[row])) for row in failed[: MOST_NAMED - len(self._failed)]
        ]
        solved = found.taken(np.flatnonzero(found.solved))
        self._largest_error_mm = max(self._largest_error_mm, float(solved.error_mm.max(initial=0.0)))
        largest = float(solved.uncertainty_mm.max(initial=0.0))
        self._largest_uncertainty_mm = max(self._largest_uncertainty_mm, largest)
        self._uncertainty_mm += float(solved.uncertainty_mm.sum())
        moved = np.nan_to_num(solved.moved_rad)
        self._far_moved += int((moved > FAR_RAD).sum())
        self._largest_move_rad = max(self._largest_move_rad, float(moved.max(initial=0.0)))
        self._zone_known = self._zone_known and not np.isnan(solved.outside_mm).any()
        beyond = (solved.outside_mm > 0.0) | (solved.outside_rad > 0.0).any(axis=1)
        self._outside += int(beyond.sum())
        self._farthest_outside_mm = max(self._farthest_outside_mm, _largest(solved.outside_mm))
        self._farthest_outside_rad = max(self._farthest_outside_rad, _largest(solved.outside_rad))

    @property
    def totals(self) -> CorrectionTotals:
        """What was counted so far; the mean uncertainty is 0 where nothing was corrected."""
        solved = sum(self._statuses[status] for status in CORRECTED)
        return CorrectionTotals(
            statuses=dict(self._statuses),
            failed=tuple(self._failed),
            largest_error_mm=self._largest_error_mm,
            mean_uncertainty_mm=self._uncertainty_mm / max(solved, 1),
            largest_uncertainty_mm=self._largest_uncertainty_mm,
            far_moved=self._far_moved,
            largest_move_rad=self._largest_move_rad,
            outside=self._outside,
            farthest_outside_mm=self._farthest_outside_mm,
            farthest_outside_rad=self._farthest_outside_rad,
            zone_known=self._zone_known,
        )


def _largest(beyond: FloatArray) -> float:
    return float(np.nan_to_num(beyond).max(initial=0.0))
