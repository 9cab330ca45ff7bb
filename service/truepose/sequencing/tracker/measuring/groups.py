"""Readings in groups, as far as a session has come: when each was taken, and where it lies on average."""

from dataclasses import dataclass, field

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.session import PointTaken
from truepose.judgement.iso9283.settling import has_settled


@dataclass(slots=True)
class Groups:
    """Sums over the readings of each group."""

    _sums: dict[int, FloatArray] = field(default_factory=dict)  # (5,) of: 1, time [s], x, y, z [mm]

    def take(self, point: PointTaken) -> None:
        """Count a reading; one that is in no group is none of this."""
        if point.group is not None:
            taken = np.array([1.0, point.time_s, *point.position_world_mm])
            self._sums[point.group] = self._sums.get(point.group, np.zeros(5)) + taken

    def settled_before(self, group: int) -> bool:
        """Whether drift had become slow by the groups before this one."""
        sums = np.array([self._sums[number] for number in sorted(self._sums) if number < group])
        if not len(sums):
            return False
        means = sums[:, 1:] / sums[:, :1]
        return has_settled(means[:, 0], means[:, 1:])
