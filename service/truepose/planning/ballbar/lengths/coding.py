"""Coded lengths: the legs of a pose aim at lengths that differ, so that exchanged legs betray themselves.

Six lengths fix six degrees of freedom, so every leg of a pose may have a length of its own. The levels are
spread evenly over +-0.7 mm, which leaves 0.3 mm of the ballbar's range for what the aim misses.

Legs that follow each other share a ball and are the ones that are confused most easily; their levels are at
least two steps apart. From pose to pose all levels move on by one, so no leg has always the same.
"""

from dataclasses import dataclass
from typing import Final

from truepose.domain.errors import ConfigurationError

SPAN_MM: Final = 0.7


@dataclass(frozen=True, slots=True)
class Code:
    """Levels of the lengths of one pose, in the order of its legs."""

    offsets_mm: tuple[float, ...]  # from the nominal length, all different
    spacing_mm: float  # between neighbouring levels; 0 for a single leg


def coded_lengths(n_legs: int, turn: int = 0) -> Code:
    """Return the offsets of n legs from the nominal length.

    Parameters
    ----------
    n_legs : int
        Six in general: +-0.7 mm in steps of 0.28. Others: as many levels, spread over the same span.
    turn : int
        Number of the pose: which leg has which level.

    Raises
    ------
    ConfigurationError
        There is no leg.
    """
    if n_legs < 1:
        raise ConfigurationError(f"{n_legs} legs cannot be coded; a pose has at least one.")
    if n_legs == 1:
        return Code((0.0,), 0.0)
    spacing = 2.0 * SPAN_MM / (n_legs - 1)
    levels = ((level + turn) % n_legs for level in _interleaved(n_legs))
    return Code(tuple(spacing * level - SPAN_MM for level in levels), spacing)


def _interleaved(n: int) -> list[int]:
    """Numbers 0..n-1 with those that follow each other far apart: 0 3 1 4 2 5 for six."""
    half = (n + 1) // 2
    return [level for pair in range(half) for level in (pair, pair + half) if level < n]
