"""What a test measures: poses that are commanded, and where each visit came to stand."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.errors import ConfigurationError
from truepose.domain.sentences import Sentence, Text, said


@dataclass(frozen=True, slots=True)
class CommandedPose:
    """One of P1 to P5, as the robot was told to take it."""

    number: int
    position_mm: tuple[float, float, float]

    @classmethod
    def at(cls, number: int, place_mm: FloatArray) -> Self:
        """Return a pose at a place of shape (3,)."""
        x, y, z = (float(value) for value in place_mm)
        return cls(number, (x, y, z))

    @property
    def name(self) -> str:
        """The standard's name."""
        return f"P{self.number}"


@dataclass(frozen=True, slots=True)
class Visits(Table):
    """Attained poses, n rows in any order; a visit that was not measured is absent, or NaN."""

    pose: IntArray  # (n,) number of the commanded pose
    cycle: IntArray  # (n,) from 1
    position_mm: FloatArray  # (n, 3)
    standard_uncertainty_mm: FloatArray  # (n,) of the instrument, per axis
    turn_rad: FloatArray | None = None  # (n, 3) from the commanded orientation: about x, y and z (a, b, c)
    rotation_uncertainty_rad: FloatArray | None = None  # (n,) of the instrument, per axis

    def __len__(self) -> int:
        return int(self.pose.size)

    def __post_init__(self) -> None:
        pose, cycle = self.pose[self.measured], self.cycle[self.measured]
        order = np.lexsort((cycle, pose))
        pose, cycle = pose[order], cycle[order]
        twice = np.flatnonzero((pose[1:] == pose[:-1]) & (cycle[1:] == cycle[:-1]))
        if len(twice):
            first = twice[0]
            raise ConfigurationError(
                f"P{pose[first]} is there twice in cycle {cycle[first]}: a pose is visited once a cycle."
            )

    @property
    def measured(self) -> BoolArray:
        """Which visits were measured, shape (n,)."""
        read = self.position_mm if self.turn_rad is None else np.hstack([self.position_mm, self.turn_rad])
        return np.asarray(np.isfinite(read).all(axis=1))

    def of_pose(self, number: int) -> "Visits":
        """Return the measured visits of one pose, by cycle."""
        rows = np.flatnonzero((self.pose == number) & self.measured)
        return self.taken(rows[np.argsort(self.cycle[rows], kind="stable")])

    def missing(self, number: int) -> tuple[int, ...]:
        """Return the cycles that one pose lacks, of all that took place."""
        cycles = np.arange(1, int(self.cycle.max(initial=0)) + 1)
        return tuple(int(cycle) for cycle in np.setdiff1d(cycles, self.of_pose(number).cycle))


def too_few(visits: Visits, number: int, least: int) -> Sentence | None:
    """Return why a pose was not visited often enough, None where it was."""
    n = len(visits.of_pose(number))
    if n >= least:
        return None
    missing = _missing(visits.missing(number))
    return said("poses.too_few", pose=f"P{number}", measured=n, missing=missing, least=least)


def _missing(cycles: tuple[int, ...]) -> Text:
    if not cycles:
        return ""
    if len(cycles) == 1:
        return said("poses.missing_one", cycle=cycles[0])
    return said("poses.missing", cycles=tuple(_runs(cycles)))


def _runs(numbers: tuple[int, ...]) -> Iterator[int | Sentence]:
    """Yield numbers that stand alone, and runs of them."""
    starts = [k for k, number in enumerate(numbers) if k == 0 or number != numbers[k - 1] + 1]
    for start, end in zip(starts, [*starts[1:], len(numbers)], strict=True):
        first, last = numbers[start], numbers[end - 1]
        yield first if first == last else said("poses.run", first=first, last=last)
