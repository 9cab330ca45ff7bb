"""The work volume that a promise holds for: joint ranges, a box, or both."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.robot import JointRange
from truepose.planning.errors import WorkSpaceError
from truepose.planning.work_volume.candidates import has_room
from truepose.planning.work_volume.keep_outs import look_at
from truepose.planning.work_volume.work_space import (
    WorkSpace,
    nest_places,
    nominal_chain,
    require_consistent,
)

VOLUME_CONFIGURATIONS: Final = 400  # the mean over them is that over the volume to about 1 %
_BATCH: Final = 2048
_MOST_BATCHES: Final = 100


@dataclass(frozen=True, slots=True)
class WorkVolume:
    """Where accuracy counts."""

    ranges: tuple[JointRange, ...] | None = None  # None: those in which configurations are chosen
    box_mm: tuple[tuple[float, float], ...] | None = None  # from and to along x, y, z of the world


@dataclass(frozen=True, slots=True)
class VolumeSample:
    """Configurations all over a volume and the nests that are in it, m rows."""

    joints_rad: FloatArray  # (m, J)
    nest: IntArray  # (m,) 1-based

    def __len__(self) -> int:
        return len(self.nest)


def sample(space: WorkSpace, volume: WorkVolume, n: int, rng: np.random.Generator) -> VolumeSample:
    """Draw n configurations uniformly in the joint ranges, every nest of each that lies in the volume.

    They are clear of table and column; whether a tracker would see them does not matter to whoever works
    there.

    Raises
    ------
    WorkSpaceError
        The arm has no place in the volume.
    """
    space = replace(space, ranges=volume.ranges or space.ranges)
    require_consistent(space)
    joints, nests, found = [], [], 0
    for _ in range(_MOST_BATCHES):
        drawn, nest = _inside(space, volume, rng)
        joints.append(drawn)
        nests.append(nest)
        found += len(drawn)
        if found >= n:
            break
    if not found:
        raise WorkSpaceError(
            f"None of {_BATCH * _MOST_BATCHES} random configurations has a tool nest in the work volume: "
            "check its box, its joint ranges and the table's height."
            f"{look_at(space.keep_outs)}"
        )
    inside = np.concatenate(nests)[:n]
    row, column = np.nonzero(inside)
    return VolumeSample(np.concatenate(joints)[:n][row], column.astype(np.int64) + 1)


def _inside(space: WorkSpace, volume: WorkVolume, rng: np.random.Generator) -> tuple[FloatArray, BoolArray]:
    """Return configurations (n, J) that have a nest in the volume, and which nests have, (n, K)."""
    low = np.array([limit.lower_rad for limit in space.ranges])
    high = np.array([limit.upper_rad for limit in space.ranges])
    drawn = low + (high - low) * rng.random((_BATCH, len(low)))
    chain = nominal_chain(space, drawn)
    nests = np.ones((_BATCH, len(space.nests)), dtype=bool)
    if volume.box_mm is not None:
        least, most = np.array(volume.box_mm).T
        places = nest_places(space, chain)
        nests = np.all((places >= least) & (places <= most), axis=2).T
    if space.camera is not None:  # a nest of its readings alone: where the tool is, the others say
        nests[:, space.camera.nest - 1] = False
    kept = has_room(space, drawn, chain) & nests.any(axis=1)
    return drawn[kept], nests[kept]
