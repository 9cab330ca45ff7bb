"""What a test measures: poses that are commanded, and where each visit came to stand."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.errors import ConfigurationError


@dataclass(frozen=True, slots=True)
class CommandedPose:
    """One of P1 to P5, as the robot was told to take it."""

    number: int
    position_mm: tuple[float, float, float]

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
        pairs = np.column_stack([self.pose, self.cycle])[self.measured]
        found, count = np.unique(pairs, axis=0, return_counts=True)
        if np.any(count > 1):
            pose, cycle = found[np.argmax(count > 1)]
            raise ConfigurationError(
                f"P{pose} is there twice in cycle {cycle}: a pose is visited once a cycle."
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


def too_few(visits: Visits, number: int, least: int) -> str | None:
    """Return why a pose was not visited often enough, None where it was."""
    n = len(visits.of_pose(number))
    if n >= least:
        return None
    missing = visits.missing(number)
    named = f" ({_cycles(missing)} {'is' if len(missing) == 1 else 'are'} missing)" if missing else ""
    return f"P{number} was measured in {n} cycles{named}; ISO 9283 asks for {least}, and none is made up"


def _cycles(numbers: tuple[int, ...]) -> str:
    if len(numbers) == 1:
        return f"cycle {numbers[0]}"
    return f"cycles {', '.join(_runs(numbers))}"


def _runs(numbers: tuple[int, ...]) -> Iterator[str]:
    """Yield "3", "7 to 9"."""
    starts = [k for k, number in enumerate(numbers) if k == 0 or number != numbers[k - 1] + 1]
    for start, end in zip(starts, [*starts[1:], len(numbers)], strict=True):
        first, last = numbers[start], numbers[end - 1]
        yield str(first) if first == last else f"{first} to {last}"
