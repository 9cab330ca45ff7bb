"""The base fixture: three cups 300 mm apart, or four at the corners of a regular tetrahedron, on a stand.

Cup 4 lies below the plane of cups 1, 2, 3 (in the frame of the fixture), because above it, at 300 mm from
all three, is where a tool nest comes. Every face of the tetrahedron that does not look down on the table
carries poses, and each cup opens halfway between those of its faces.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.planning.ballbar.clear_ways.capsules import Capsules, joined, still

BALL_MM: Final = 10.0  # from the centre of a half-inch ball to the body of the cup behind it
CUP_RADIUS_MM: Final = 8.0
HUB_DEPTH_MM: Final = 60.0  # of the star that carries three cups, below their plane
POST_MM: Final = 40.0  # below which a cup hangs on an arm
STAND_RADIUS_MM: Final = 20.0
_LOWEST_FACE: Final = -0.05  # upward part of the normal of a face that still carries poses


# Without slots: searches ask thousands of times where the cups of one fixture open.
@dataclass(frozen=True)
class BaseFixture:
    """A base fixture at its nominal place: cup k in row k - 1."""

    number: int  # of the placement, from 1
    frame: FramePlacement  # of the base triangle in the world
    cups_mm: FloatArray  # (3, 3) or (4, 3), world

    @property
    def normal(self) -> FloatArray:
        """Unit vector of the side of the base triangle on which the tool is, shape (3,)."""
        return np.asarray(placement_rotation(self.frame)[:, 2])

    @property
    def own_cups_mm(self) -> FloatArray:
        """The cups in the frame of the fixture, shape (K, 3)."""
        return np.asarray((self.cups_mm - placement_translation(self.frame)) @ placement_rotation(self.frame))

    @cached_property
    def hub_mm(self) -> FloatArray:
        """Where the arms to the cups meet, shape (3,)."""
        centre = np.asarray(self.cups_mm.mean(axis=0))
        return centre if len(self.cups_mm) == 4 else centre - HUB_DEPTH_MM * self.normal

    @cached_property
    def axes(self) -> FloatArray:
        """Direction in which each cup opens, shape (K, 3)."""
        axes = np.zeros_like(self.cups_mm)
        for face in self.faces:
            axes[[point - 1 for point in face]] += self._outwards(face)
        idle = ~axes.any(axis=1)
        axes[idle] = (self.cups_mm - self.hub_mm)[idle]
        return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))

    @cached_property
    def faces(self) -> tuple[tuple[int, ...], ...]:
        """Every three base points (1-based) that carry poses."""
        if len(self.cups_mm) == 3:
            return ((1, 2, 3),)
        every = combinations((1, 2, 3, 4), 3)
        return tuple(face for face in every if self._outwards(face)[2] > _LOWEST_FACE)

    def _outwards(self, face: tuple[int, ...]) -> FloatArray:
        away = self.cups_mm[[point - 1 for point in face]].mean(axis=0) - self.hub_mm
        return np.asarray(away / np.linalg.norm(away))


def base_fixture(number: int, frame: FramePlacement, points: int = 3, side_mm: float = 300.0) -> BaseFixture:
    """Return a fixture of three or four cups at a place.

    Parameters
    ----------
    number : int
        Of the placement, from 1.
    frame : FramePlacement
        In the world: cup 1 its origin, cup 2 on x, cup 3 in the xy plane, cup 4 below it.
    points : int
        3 or 4.
    side_mm : float
        Between every two cups.

    Raises
    ------
    ConfigurationError
        Another number of cups, or a length that is none.
    """
    if points not in {3, 4}:
        raise ConfigurationError(f"A base fixture has 3 or 4 cups, not {points}.")
    if not 0.0 < side_mm < np.inf:
        raise ConfigurationError(f"The cups cannot be {side_mm:g} mm apart; give a length above 0.")
    height = np.sqrt(3.0) / 2.0
    unit = np.array([
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.5, height, 0.0],
        [0.5, height / 3.0, -np.sqrt(2.0 / 3.0)],
    ])
    cups = side_mm * unit[:points] @ placement_rotation(frame).T + placement_translation(frame)
    return BaseFixture(number, frame, cups)


def fixture_body(fixture: BaseFixture, table_z_mm: float) -> Capsules:
    """Return the posts of the cups (first, in order), the arms that carry them, the stand on the table."""
    feet = fixture.cups_mm - BALL_MM * fixture.axes
    bottoms = fixture.cups_mm - POST_MM * fixture.axes
    below = np.array([*fixture.hub_mm[:2], table_z_mm])
    posts = still(list(zip(feet, bottoms, strict=True)), CUP_RADIUS_MM)
    arms = still([(bottom, fixture.hub_mm) for bottom in bottoms], CUP_RADIUS_MM)
    return joined([posts, arms, still([(fixture.hub_mm, below)], STAND_RADIUS_MM)])
